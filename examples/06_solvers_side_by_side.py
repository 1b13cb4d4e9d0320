"""Give the hierarchies of the tray to every solver, and certify what each one answers.

The motion generator follows the default solver; at every tenth tick the other solvers get the
same problem. The certificate knows no solver: it bounds how far above its optimum each level is.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from statistics import median
from time import perf_counter

from equipoise import Hierarchy, Solution, make_solver, read_scenario
from equipoise.simulation.simulation import Simulation

SOLVERS = ("active_set", "cascade", "daqp")


@dataclass
class Outcome:
    """What one solver did: certificates that hold, worst excess [m/s, rad/s] of each, times."""

    holds: int = 0
    excess: list[float] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)

    @property
    def median_us(self) -> float:
        """Median time of a solution [us]."""
        return 1e6 * median(self.seconds)

    def certify(self, hierarchy: Hierarchy, solution: Solution) -> None:
        """Count one certificate."""
        certificate = solution.certificate(hierarchy)
        self.holds += certificate.holds()
        self.excess.append(max(level.excess for level in certificate.levels))


def main(duration: float = 6.2, stride: int = 10, *overrides: str) -> dict[str, Outcome]:
    """Solve every `stride`-th hierarchy of the tray's first `duration` seconds three times."""
    simulation = Simulation(read_scenario("tray", overrides))
    solvers = {name: make_solver(name) for name in SOLVERS}
    outcomes = {name: Outcome() for name in SOLVERS}
    for k in range(round(duration / simulation.dt)):
        hierarchy = simulation.controller.motion.step(k * simulation.dt).hierarchy
        for name, solver in solvers.items():
            if name != "active_set" and k % stride:
                continue  # the warm-started solver sees every problem, as it does in a run
            began = perf_counter()
            solution = solver.solve(hierarchy)
            outcomes[name].seconds.append(perf_counter() - began)
            if k % stride == 0:
                outcomes[name].certify(hierarchy, solution)
    for name, outcome in outcomes.items():
        print(
            f"{name:<11}{outcome.holds} of {len(outcome.excess)} certificates hold, worst excess "
            f"{max(outcome.excess):.1e}, median {outcome.median_us:.0f} us"
        )
    return outcomes


if __name__ == "__main__":
    given = sys.argv[1:]
    main(*(float(given[0]) if given else 6.2, int(given[1]) if len(given) > 1 else 10), *given[2:])
