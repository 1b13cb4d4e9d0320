"""The solver as kernels: `solve` for other kernels to call, `judge` for what it did, on demand."""

from __future__ import annotations

import numpy as np

from equipoise.compiled import Stage, compiled
from equipoise.compiled.workspace import Block, integer_matrix, integers, vector
from equipoise.hqp.solution import ACTIVE_TOLERANCE
from equipoise.hqp.solvers.active_set.memory import (
    ACTIVE,
    COUNTS,
    ENDS,
    EQUALITY,
    FAILED,
    KNOWN,
    LAST_V,
    LOWER,
    MET,
    ORDER,
    SIDES,
    SLACK,
    UPPER,
    V,
    W,
)
from equipoise.hqp.solvers.active_set.passes import solve_levels
from equipoise.hqp.solvers.active_set.primitives import copy_vector
from equipoise.hqp.solvers.active_set.values import value_of


@compiled
def solve(rows: Block, search: Block, limit: int) -> int:
    """Find the lexicographic optimum of the rows; return SOLVED, ITERATION_LIMIT or FAILED.

    v is the answer; after FAILED it is zero, and nothing is remembered. `limit` bounds the working
    problems of a level.
    """
    outcome = solve_levels(rows, search, limit)
    v, total = vector(search, V), 0.0
    for c in range(v.shape[0]):
        total += v[c]
    if abs(total) < np.inf:
        copy_vector(vector(search, LAST_V), v, v.shape[0])
        return outcome
    for c in range(v.shape[0]):
        v[c] = 0.0
        vector(search, LAST_V)[c] = 0.0
    forget_all(search)
    return FAILED


@compiled
def forget_all(search: Block) -> None:
    """Forget the last answer: the next problem is solved as if it were the first."""
    integers(search, KNOWN)[0] = 0
    integers(search, MET)[:] = 0
    integers(search, ORDER)[:] = -1
    sides = integer_matrix(search, SIDES)
    for number in range(sides.shape[0]):
        for row in range(sides.shape[1]):
            sides[number, row] = 0


@compiled
def judge(rows: Block, search: Block) -> None:
    """Fill w, slack and active at v."""
    low, high, counts = vector(rows, LOWER), vector(rows, UPPER), integers(search, COUNTS)
    v, w, slack = vector(search, V), vector(search, W), vector(search, SLACK)
    ends, active = integers(rows, ENDS), integers(search, ACTIVE)
    start = 0
    for level in range(ends.shape[0]):
        squares = 0.0
        for row in range(start, ends[level]):
            w[row], active[row] = 0.0, 0
            if counts[row] == 0 or (low[row] == -np.inf and high[row] == np.inf):
                continue
            value = value_of(rows, row, v)
            w[row] = value - min(max(value, low[row]), high[row])
            squares += w[row] ** 2
            near = ACTIVE_TOLERANCE * (1.0 + abs(value))
            active[row] = int(value >= high[row] - near) - int(value <= low[row] + near)
            if low[row] == high[row]:
                active[row] = EQUALITY
        slack[level] = np.sqrt(squares)
        start = ends[level]


SOLVE = Stage(0, solve)  # the solver as other kernels call it
solve_there = SOLVE.call
