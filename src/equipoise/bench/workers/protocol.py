"""The talk of a worker with `bench.apart`: it reads its task, is told ticks, answers with times.

Imports nothing of Equipoise: it runs beside the worker, in the Python of its peer.
"""

import json
import sys
from pathlib import Path

import numpy as np


def serve(make_tick, about):
    """Make the tick of `task, targets` and run it as each line "first count" of the input says.

    A tick has `run(k)`, which returns the time [ns] and 1 if it failed, and `error(k)` [m].
    """
    place = Path(sys.argv[1])
    task = json.loads((place / "task.json").read_text(encoding="utf-8"))
    tick = make_tick(task, dict(np.load(place / "targets.npz")))
    _say({"about": about})
    for line in sys.stdin:
        first, count = map(int, line.split())
        done = [tick.run(k) for k in range(first, first + count)]
        _say(
            {
                "ns": [ns for ns, _ in done],
                "failures": sum(failed for _, failed in done),
                "error": tick.error(first + count - 1),
            }
        )


def _say(answer):
    print(json.dumps(answer), flush=True)
