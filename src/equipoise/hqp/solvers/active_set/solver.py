"""Our own hierarchical active-set solver: exact for eq. (15), compiled, started where it ended."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from equipoise.compiled.compilation import announce
from equipoise.hqp.hierarchy import Hierarchy
from equipoise.hqp.solution import Solution, Status, describe
from equipoise.hqp.solvers.active_set.hierarchy import answer
from equipoise.hqp.solvers.active_set.primitives import Buffers, allocate

_FLOAT = np.dtype(np.float64)


@cache
def prepare_kernels() -> None:
    """Load the compiled kernels by solving a tiny problem; compile them once, and say so."""
    announce(Path(__file__).parent)
    buffers, one = allocate(1, 1, 1), np.ones(1)
    active = np.zeros(1, dtype=np.int8)
    outcome = one.copy(), one.copy(), one.copy(), active
    answer(np.ones((1, 1)), one, one, np.array([1]), *buffers, 1, *outcome)


class ActiveSet:
    """Solver of eq. (15) by one orthogonal factorisation that shrinks from level to level.

    Rows that the optimum of a level determines (equalities, violated rows, rows with a multiplier)
    are eliminated for good; satisfied ones stay as hard rows for the levels below. The working rows
    of the last answer are tried first, so a problem that changes little costs one elimination.
    `iteration_limit` bounds the working problems of a level. The first solver of a process loads
    the compiled kernels, and compiles them where that was never done (see `compilation`).
    """

    name = "active_set"

    def __init__(self, iteration_limit: int = 1000) -> None:
        self.iteration_limit = iteration_limit
        self._shape: tuple[int, int, int] = (0, 0, 0)
        self._ends: tuple[int, ...] = ()
        self._buffers: Buffers | None = None
        prepare_kernels()

    def reset(self) -> None:
        """Forget the last answer; the next problem is solved as if it were the first."""
        if self._buffers is not None:
            self._buffers.memory[:] = 0

    def solve(self, hierarchy: Hierarchy) -> Solution:
        """Return the lexicographic optimum; a numerical outcome is a status."""
        n, m, ends = hierarchy.n, len(hierarchy.lower), hierarchy.ends
        if m == 0:
            return describe(hierarchy, np.zeros(n), Status.SOLVED, self.name, 0)
        buffers, limits = self._prepare(m, n, ends)
        v, w, slack = np.empty(n), np.empty(m), np.empty(len(ends))
        active = np.empty(m, dtype=np.int8)
        work, ended, finite = answer(
            _plain(hierarchy.A),
            _plain(hierarchy.lower),
            _plain(hierarchy.upper),
            limits,
            *buffers,
            self.iteration_limit,
            v,
            w,
            slack,
            active,
        )
        if not finite:
            self.reset()
            return describe(hierarchy, np.full(n, np.nan), Status.FAILED, self.name, work)
        status = Status.SOLVED if ended else Status.ITERATION_LIMIT
        return Solution(v, w, tuple(slack.tolist()), active, status, self.name, work)

    def _prepare(self, m: int, n: int, ends: tuple[int, ...]) -> tuple[Buffers, np.ndarray]:
        shape = (m, n, len(ends))
        if self._buffers is None or shape != self._shape:
            self._buffers, self._shape = allocate(m, n, len(ends)), shape
        if ends != self._ends:
            self._ends, self._limits = ends, np.array(ends, dtype=np.int64)
            self._buffers.memory[:] = 0
        return self._buffers, self._limits


def _plain(array: np.ndarray) -> np.ndarray:
    """Return the array in the one layout that the kernels are compiled for."""
    if array.flags.carray and array.dtype == _FLOAT:
        return array
    return np.array(array, dtype=np.float64, order="C")
