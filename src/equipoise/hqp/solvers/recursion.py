"""The recursion of pseudo-inverses, eq. (14): strict priorities, equalities only."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from equipoise.errors import InputError
from equipoise.hqp.hierarchy import Hierarchy
from equipoise.hqp.solution import Solution, Status, describe


@dataclass(frozen=True, slots=True)
class Recursion:
    """Solver by the recursion of pseudo-inverses; it knows equalities only.

    `rank_tolerance`: singular values below this share of the largest row norm of their level count
    as zero. `damping` [unit of A]: smallest singular value that is inverted undamped; below it
    the inverse is bent to s / (s^2 + c^2), with c growing to `damping` as s falls to zero.

    Source: eq. (14). Differs from the print: the projector is kept as an orthonormal basis of the
    free directions, which is the same in exact arithmetic and keeps the levels strict to rounding.
    """

    rank_tolerance: float = 1e-10
    damping: float = 0.0
    name: str = "recursion"

    def solve(self, hierarchy: Hierarchy) -> Solution:
        """Return the answer.

        Raises:
            InputError: a row is an inequality; names the block.
        """
        _refuse_inequalities(hierarchy)
        v = np.zeros(hierarchy.n)
        free = np.eye(hierarchy.n)
        for i in range(len(hierarchy.ends)):
            rows = hierarchy.level(i)
            A, target = hierarchy.A[rows], hierarchy.lower[rows]
            if not len(target) or not free.shape[1]:
                continue
            left, s, right = np.linalg.svd(A @ free)
            cut = self.rank_tolerance * float(np.linalg.norm(A, axis=1).max())
            rank = int((s > cut).sum())
            inverse = self._invert(s[:rank])
            v = v + free @ (right[:rank].T @ (inverse * (left[:, :rank].T @ (target - A @ v))))
            free = free @ right[rank:].T
        return describe(hierarchy, v, Status.SOLVED, self.name, len(hierarchy.ends))

    def _invert(self, s: np.ndarray) -> np.ndarray:
        if self.damping <= 0.0:
            return 1.0 / s
        share = np.minimum(s / self.damping, 1.0)
        return s / (s**2 + self.damping**2 * (1.0 - share**2))


def _refuse_inequalities(hierarchy: Hierarchy) -> None:
    unequal = hierarchy.lower != hierarchy.upper
    if unequal.any():
        block = hierarchy.block_of(int(np.flatnonzero(unequal)[0]))
        raise InputError(
            f"The recursion of eq. (14) knows equalities only, and rows {block.name!r} of level "
            f"{block.level} are inequalities",
            given=block.name,
            remedy="Take the solver 'active_set', 'cascade' or 'daqp', or leave these rows out",
        )
