"""The cascade of QPs, eq. (15), one a level in the null space of the levels above: the reference.

It is written to be read and to be exact, not to be fast.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from equipoise.hqp.hierarchy import Hierarchy
from equipoise.hqp.solution import Solution, Status, describe
from equipoise.hqp.solvers.level_problem import HardRows, LevelProblem, solve_level


@dataclass(frozen=True, slots=True)
class Cascade:
    """Solver by one least-squares problem a level, eq. (15), and a last one for the least norm.

    Equalities, violated rows and rows that carry a multiplier are fixed by what is solved already
    and leave through an orthonormal basis; the other rows stay as hard bounds for the levels below.
    Rows are judged in comparison with their own length.

    Source: eq. (15). Differs from the print: the levels above are held by that basis instead of
    as rows of the QP, which would be infeasible by rounding.
    """

    iteration_limit: int = 2000
    name: str = "cascade"

    def solve(self, hierarchy: Hierarchy) -> Solution:
        """Return the lexicographic optimum."""
        n = hierarchy.n
        v, basis, iterations = np.zeros(n), np.eye(n), 0
        status = Status.SOLVED
        hard = HardRows.none(n)
        for A, lower, upper in _levels(hierarchy):
            problem = LevelProblem(A, lower, upper, hard, v, basis)
            result = solve_level(problem, self.iteration_limit)
            iterations += result.iterations
            if not result.converged:
                status = Status.ITERATION_LIMIT
            v, basis, hard = result.v, result.basis, result.hard
            if basis.shape[1] == 0:
                break
        return describe(hierarchy, v, status, self.name, iterations)


def _levels(hierarchy: Hierarchy) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Yield the rows of each level, and last the rows `v = 0` that pick the least norm."""
    for i in range(len(hierarchy.ends)):
        rows = hierarchy.level(i)
        if rows.stop > rows.start:
            yield hierarchy.A[rows], hierarchy.lower[rows], hierarchy.upper[rows]
    zero = np.zeros(hierarchy.n)
    yield np.eye(hierarchy.n), zero, zero
