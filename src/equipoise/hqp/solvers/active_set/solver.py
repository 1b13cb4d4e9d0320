"""Our own hierarchical active-set solver: exact for eq. (15), compiled, started where it ended."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equipoise.compiled.compilation import compiled, entrance
from equipoise.compiled.workspace import (
    Arrays,
    Block,
    Workspace,
    integers,
    matrix,
    part_of,
    vector,
)
from equipoise.hqp.hierarchy import Hierarchy
from equipoise.hqp.solution import Solution, Status, describe
from equipoise.hqp.solvers.active_set.memory import (
    A_ROWS,
    FAILED,
    FIRST,
    LAST,
    LOWER,
    SEARCH_MEMORY,
    SINGLE,
    SLACK,
    UPPER,
    WORKS,
    V,
    rows_shapes,
    search_shapes,
)
from equipoise.hqp.solvers.active_set.solve import SOLVE, judge, solve_there
from equipoise.hqp.soundness import length_if_sound

STATUS = Status.SOLVED, Status.ITERATION_LIMIT, Status.FAILED
_CALLER = Arrays(("v", "columns"), frozenset({"columns"}))
CALLERS_V, COLUMNS = range(2)
_FLOAT = np.dtype(np.float64)


@entrance
def answer(
    A: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    floats: np.ndarray,
    whole: np.ndarray,
    tables: np.ndarray,
    limit: int,
) -> int:
    """Copy a problem into the workspace, solve it and judge the answer; return how it ended."""
    rows, search = part_of(floats, whole, tables, 0), part_of(floats, whole, tables, 1)
    caller = part_of(floats, whole, tables, 2)
    if not load(rows, integers(caller, COLUMNS), A, lower, upper):
        return FAILED
    outcome = solve_there(rows, search, limit)
    judge(rows, search)
    v, columns, total = vector(search, V), integers(caller, COLUMNS), 0.0
    for c in range(v.shape[0]):
        vector(caller, CALLERS_V)[columns[c]] = v[c]
    for slack in vector(search, SLACK):
        total += slack
    return outcome if total < np.inf else FAILED


@compiled
def load(
    rows: Block, columns: np.ndarray, A: np.ndarray, lower: np.ndarray, upper: np.ndarray
) -> bool:
    """Copy a problem into the part `rows`, its columns in another order; False if it is unsound.

    Rows without bounds are not copied: nobody reads them.
    """
    own, low, high = matrix(rows, A_ROWS), vector(rows, LOWER), vector(rows, UPPER)
    first, last, single = integers(rows, FIRST), integers(rows, LAST), integers(rows, SINGLE)
    m, n = A.shape
    for row in range(m):
        low[row], high[row] = lower[row], upper[row]
        if low[row] == -np.inf and high[row] == np.inf:
            continue
        for c in range(n):
            own[row, c] = A[row, columns[c]]
        if length_if_sound(own, low, high, row) < 0.0:
            return False
        begin, end = 0, n
        while begin < end and own[row, begin] == 0.0:
            begin += 1
        while end > begin and own[row, end - 1] == 0.0:
            end -= 1
        first[row], last[row] = begin, end
        single[row] = begin if end == begin + 1 else -1
    return True


@cache
def prepare_kernels() -> None:
    """Load the compiled kernels by solving a tiny problem, and compile them where needed."""
    made, one = _workspace(1, 1, (1,)), np.ones(1)
    answer(np.ones((1, 1)), one, one, made.floats, made.integers, made.tables, 1)


def _workspace(m: int, n: int, ends: tuple[int, ...]) -> Workspace:
    """Return a workspace for a problem, cold, its columns in the order of the caller."""
    levels = len(ends)
    parts = {"rows": rows_shapes(m, n, levels), "search": search_shapes(m, n, levels)}
    parts["caller"] = _CALLER.shapes(v=n, columns=n)
    made = Workspace(parts, tuple(f"search.{name}" for name in SEARCH_MEMORY), [SOLVE])
    made.rows.ends[:] = ends
    made.search.counts[:] = 1
    made.caller.columns[:] = np.arange(n)
    return made


def _in_order_of_touch(hierarchy: Hierarchy) -> NDArray[np.int64]:
    """Return the columns [n] in the order in which equalities touch them: rows stay narrow."""
    touched = hierarchy.A[hierarchy.lower == hierarchy.upper] != 0.0
    never = np.ones((1, hierarchy.n), dtype=bool)
    return np.argsort(np.vstack([touched, never]).argmax(axis=0), kind="stable")


class ActiveSet:
    """Solver of eq. (15): one factorisation for all levels that can be met, one for each other.

    `iteration_limit` bounds the working problems of a level. The first solver of a process loads
    the compiled kernels, and compiles them where that was never done (see `compilation`).
    """

    name = "active_set"

    def __init__(self, iteration_limit: int = 1000) -> None:
        self.iteration_limit = iteration_limit
        self._layout: tuple[int, int, tuple[int, ...]] | None = None
        self._workspace = _workspace(1, 1, (1,))
        prepare_kernels()

    def reset(self) -> None:
        """Forget the last answer; the next problem is solved as if it were the first."""
        for name in SEARCH_MEMORY:
            getattr(self._workspace.search, name)[...] = 0

    def state(self) -> dict[str, NDArray[Any]]:
        """Return a copy of all that the next answer depends on beside its problem."""
        return self._workspace.memory()

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Take back what `state` of a solver for problems of the same layout returned."""
        self._workspace.restore(state)

    def solve(self, hierarchy: Hierarchy) -> Solution:
        """Return the lexicographic optimum; a numerical outcome is a status."""
        n, m, ends = hierarchy.n, len(hierarchy.lower), hierarchy.ends
        if m == 0 or n == 0:
            return describe(hierarchy, np.zeros(n), Status.SOLVED, self.name, 0)
        if (m, n, ends) != self._layout:
            self._layout, self._workspace = (m, n, ends), _workspace(m, n, ends)
            self._workspace.caller.columns[:] = _in_order_of_touch(hierarchy)
        made = self._workspace
        outcome = answer(
            _plain(hierarchy.A),
            _plain(hierarchy.lower),
            _plain(hierarchy.upper),
            made.floats,
            made.integers,
            made.tables,
            self.iteration_limit,
        )
        search = made.search
        works = int(search.numbers[WORKS])
        if outcome == FAILED:
            return describe(hierarchy, np.full(n, np.nan), Status.FAILED, self.name, works)
        v, w, active = made.caller.v.copy(), search.w.copy(), search.active.astype(np.int8)
        slack = tuple(search.slack.tolist())
        return Solution(v, w, slack, active, STATUS[outcome], self.name, works)


def _plain(array: np.ndarray) -> np.ndarray:
    """Return the array in the one layout that the kernels are compiled for."""
    if array.flags.carray and array.dtype == _FLOAT:
        return array
    return np.array(array, dtype=np.float64, order="C")
