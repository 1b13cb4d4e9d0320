"""How many runs a minute and core a study does, and where their time goes.

`python benchmarks/study_speed.py [--runs 40] [--duration 3] [--workers 1]`

The press in MuJoCo with a load and a delay, as the shipped study payload_delay has it, by the
shipped law. `wall` counts what a person waits for: the study as a whole, its workers once ready.
`processor` counts seconds of the processor alone, which other programs on the machine do not
lengthen (they still spoil its caches). The loop's share, the rest (building, measuring), and what
the motion generation costs, which is all that references kept from run to run could save, are told
of one process.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from equipoise.studies.drive import run_study
from equipoise.studies.give_out import Standing
from equipoise.studies.plan import Plan
from equipoise.studies.read import read_study
from equipoise.studies.results import load_results
from equipoise.studies.runner import Runner
from equipoise.studies.schema import StudySpec


def study(given: argparse.Namespace) -> StudySpec:
    """Return the study: so many points, one controller."""
    return read_study(
        "payload_delay",
        [
            "only=[passivity]",
            f"designs={{main: {{kind: sobol, points: {given.runs}}}}}",
            f"set.duration={given.duration}",
            f"engine.workers={given.workers}",
            "stop_when_off=false",
            "logs=0",
        ],
    )


def motion_cpu(spec: StudySpec) -> float:
    """Return how long [s] the motion generation of one run takes alone."""
    runner = Runner(spec)
    run = next(iter(Plan(spec).first()))
    best = np.inf
    for _ in range(3):
        simulation = runner.simulation(run)
        motion, began = simulation.controller.motion, time.process_time()
        for k in range(simulation.steps):
            motion.step(k * simulation.dt)
        best = min(best, time.process_time() - began)
    return best


def main(arguments: list[str] | None = None) -> int:
    """Measure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=40)
    parser.add_argument("--duration", type=float, default=3.0, help="of a run [s]")
    parser.add_argument("--workers", type=int, default=1)
    given = parser.parse_args(arguments)
    spec = study(given)
    seen: list[tuple[float, int]] = []

    def note(standing: Standing) -> None:
        if standing.done and (not seen or standing.done > seen[-1][1]):
            seen.append((time.monotonic(), standing.done))

    with tempfile.TemporaryDirectory() as place:
        run_study(spec, Path(place) / "study", report=note)
        results = load_results(Path(place) / "study")
        times = results.times
        (first, before), (last, done) = seen[0], seen[-1]
        whole = results["t_end"] >= given.duration - 1e-9
    cpu, loop = float(np.mean(times["cpu"][1:])), float(np.mean(times["loop_cpu"][1:]))
    rate = (done - before) / (last - first) / given.workers
    told = {
        "runs": len(results),
        "that reached their end": int(whole.sum()),
        "a minute and core, wall": round(60.0 * rate, 1),
        "a minute and core, processor": round(60.0 / cpu, 1),
        "processor time of a run [s]": round(cpu, 3),
        "of it the loop [s]": round(loop, 3),
        "motion generation alone, at most [s]": round(motion_cpu(spec), 3),
    }
    print(json.dumps(told, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
