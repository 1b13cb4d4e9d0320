"""Every answer of the solver held against its certificate, by the thousand.

`python benchmarks/certify_ticks.py tray telephone hard:hrp2 hard:talos [--ticks 10000]`: motion
generation alone, as the scenario asks for it (or with the hands thrown half a metre out of reach
every ten ticks). Counts answers that are not "solved" or not finite, and tells the largest excess
over the certified optimum, as a share of the size of the level's rows. Ends with 1 if an answer
failed or an excess is above 1e-6 of that size.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from multiprocessing import Pool
from time import perf_counter

import numpy as np

from equipoise.bench.problem import HANDS, make_problem
from equipoise.bench.unreachable_targets import throw_hands
from equipoise.hqp import make_solver
from equipoise.motion import MotionGenerator, MotionStep
from equipoise.scenarios import read_scenario
from equipoise.simulation.simulation import Simulation

TOLERANCE = 1e-6


def steps_of(case: str, ticks: int) -> Iterator[MotionStep]:
    """Yield the ticks of a scenario, or `ticks` of the hard case of a robot."""
    if case.startswith("hard:"):
        problem = make_problem(case.removeprefix("hard:"))
        levels, solver = throw_hands(problem, HANDS), make_solver("active_set")
        motion = MotionGenerator(problem.robot, levels, solver, problem.dt, problem.q_start)
        dt = problem.dt
    else:
        simulation = Simulation(read_scenario(case))
        motion, dt, ticks = simulation.controller.motion, simulation.dt, simulation.steps
    for k in range(ticks):
        yield motion.step(k * dt)


def certify(case: str, ticks: int) -> tuple[str, bool]:
    """Return what came out, in a line, and whether it is good."""
    began = perf_counter()
    count = failed = 0
    worst, where = 0.0, ""
    for step in steps_of(case, ticks):
        count += 1
        solution, hierarchy = step.solution, step.hierarchy
        if not solution.solved or not np.isfinite(solution.v).all():
            failed += 1
            continue
        certificate = solution.certificate(hierarchy)
        for i, level in enumerate(certificate.levels):
            share = level.excess / level.scale if level.excess > 0.0 else 0.0
            if share > worst:
                worst, where = share, f" (t = {step.t:.3f} s, level {i}, {level.excess:.1e})"
    seconds = perf_counter() - began
    line = f"{case}: {count} ticks, {failed} failed, largest excess {worst:.1e} of the size{where}"
    return f"{line}; {seconds:.0f} s", failed == 0 and worst <= TOLERANCE


def main() -> int:
    """Certify the cases that are named."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("cases", nargs="+", help="scenarios, or hard:ROBOT")
    parser.add_argument("--ticks", type=int, default=10_000, help="of the hard case [10000]")
    parser.add_argument("--processes", type=int, default=1)
    given = parser.parse_args()
    good = True
    with Pool(given.processes) as pool:
        jobs = [pool.apply_async(certify, (case, given.ticks)) for case in given.cases]
        for job in jobs:
            line, holds = job.get()
            print(line, flush=True)
            good = good and holds
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
