"""The talk of a worker with `bench.apart`: it reads its task, is told ticks, answers with times.

Imports nothing of Equipoise: it runs beside the worker, in the Python of its peer.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol, TypedDict

import numpy as np


class Asked(TypedDict):
    """The task as `bench.apart` writes it: a robot, what it follows, and where it starts."""

    urdf: str
    dt: float
    links: dict[str, str]
    feet: list[str]
    hands: list[str]
    soles: dict[str, list[list[float]]]
    joints: list[str]
    velocity_max: list[float]
    q_start: list[float]
    q_posture: list[float]


class WorkerTick(Protocol):
    """What a worker runs, tick after tick."""

    def run(self, k: int) -> tuple[int, int]:
        """Return the time [ns] of tick k, and 1 if it failed."""

    def error(self, k: int) -> float:
        """Return how far [m] it was from its targets at tick k."""


def serve(make_tick: Callable[[Asked, dict[str, np.ndarray]], WorkerTick], about: str) -> None:
    """Make the tick of `task, targets` and run it as each line "first count" of the input says."""
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


def _say(answer: dict[str, Any]) -> None:
    print(json.dumps(answer), flush=True)
