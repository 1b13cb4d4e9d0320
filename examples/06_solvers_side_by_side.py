"""Give the hierarchies of the tray to every solver, and certify what each one answers.

The motion generator follows the default solver; at every tenth tick the other solvers get the
same problem. The certificate knows no solver: it bounds how far above its optimum each level is.
"""

from __future__ import annotations

import sys
from time import perf_counter

import numpy as np

from equipoise import read_scenario
from equipoise.hqp import make_solver
from equipoise.scenarios.simulation import Simulation

SOLVERS = ("active_set", "cascade", "daqp")


def main(duration: float = 6.2, stride: int = 10, *overrides: str) -> None:
    """Solve every `stride`-th hierarchy of the tray's first `duration` seconds three times."""
    simulation = Simulation(read_scenario("tray", overrides))
    solvers = {name: make_solver(name) for name in SOLVERS}
    excess: dict[str, list[list[float]]] = {name: [] for name in SOLVERS}
    slack: dict[str, list[tuple[float, ...]]] = {name: [] for name in SOLVERS}
    spent: dict[str, list[float]] = {name: [] for name in SOLVERS}
    holds = dict.fromkeys(SOLVERS, 0)
    for k in range(round(duration / simulation.dt)):
        hierarchy = simulation.motion.step(k * simulation.dt).hierarchy
        for name, solver in solvers.items():
            if name != "active_set" and k % stride:
                continue  # the warm-started solver sees every problem, as it does in a run
            began = perf_counter()
            solution = solver.solve(hierarchy)
            spent[name].append(perf_counter() - began)
            if k % stride == 0:
                certificate = solution.certificate(hierarchy)
                holds[name] += certificate.holds()
                excess[name].append([level.excess for level in certificate.levels])
                slack[name].append(solution.slack)
    for name in SOLVERS:
        worst = np.max(excess[name], axis=0)
        print(f"{name:<11}{holds[name]} of {len(excess[name])} certificates hold", end=", ")
        print(f"median {1e6 * np.median(spent[name]):.0f} us")
        print("   worst excess by level:", "  ".join(f"{x:.1e}" for x in worst))
        print("   worst slack by level: ", "  ".join(f"{x:.1e}" for x in np.max(slack[name], 0)))


if __name__ == "__main__":
    given = sys.argv[1:]
    main(*(float(given[0]) if given else 6.2, int(given[1]) if len(given) > 1 else 10), *given[2:])
