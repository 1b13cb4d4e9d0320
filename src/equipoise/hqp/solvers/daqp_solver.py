"""The hierarchy mode of the DAQP library behind our protocol: fast, with its own idea of least."""

from __future__ import annotations

from dataclasses import dataclass

import daqp
import numpy as np

from equipoise.hqp.hierarchy import Hierarchy
from equipoise.hqp.solution import Solution, Status, describe

EQUALITY_SENSE = 5
OPTIMAL_FLAGS = (1, 2)  # 2: some rows were softened
ITERATION_FLAG = 4
NO_BOUND = 1e30


@dataclass(frozen=True, slots=True)
class DaqpSolver:
    """Solver by DAQP's hierarchical mode, all levels soft, H = I.

    DAQP divides every row by its norm, so on a level that cannot be met it minimises
    `sum (w_r / |a_r|)^2` and not the `sum w_r^2` of eq. (15); where the level can be met, or its
    rows have equal norms, the two agree. Levels are held to about `rho_soft`. Where equalities of
    a level depend on those above (feet that a contact holds already) it can give up the levels
    below and still call the problem solved; two such rows in three unknowns are enough. So neither
    its flag nor its slack tells: `Solution.certificate` does.
    """

    rho_soft: float = 1e-10
    iteration_limit: int = 1000
    name: str = "daqp"

    def solve(self, hierarchy: Hierarchy) -> Solution:
        """Return DAQP's answer, with residuals computed from v."""
        n, m = hierarchy.n, len(hierarchy.lower)
        if m == 0:
            return describe(hierarchy, np.zeros(n), Status.SOLVED, self.name, 0)
        sense = np.zeros(m, dtype=np.int32)
        sense[hierarchy.lower == hierarchy.upper] = EQUALITY_SENSE
        breaks = np.array([0, *sorted(set(hierarchy.ends) - {0})], dtype=np.int32)
        v, _, flag, info = daqp.solve(
            np.eye(n),
            np.zeros(n),
            np.ascontiguousarray(hierarchy.A),
            np.minimum(hierarchy.upper, NO_BOUND),
            np.maximum(hierarchy.lower, -NO_BOUND),
            sense,
            break_points=breaks,
            rho_soft=self.rho_soft,
            iter_limit=self.iteration_limit,
        )
        iterations = int(info["iterations"])
        return describe(hierarchy, np.array(v), _status(flag), self.name, iterations)


def _status(flag: int) -> Status:
    if flag in OPTIMAL_FLAGS:
        return Status.SOLVED
    return Status.ITERATION_LIMIT if flag == ITERATION_FLAG else Status.FAILED
