"""Compiled solution of one working problem: hard rows first, then least squares of soft ones.

After the reflectors spent on solved levels, the hard working rows take the next ones (a lower
triangle), and the soft rows those after (a lower trapezoid, largest remaining row first).
"""

from __future__ import annotations

import numpy as np

from equipoise.compiled.compilation import compiled, inlined
from equipoise.hqp.solvers.active_set.multiplier import (
    share_out,
    weigh_by_goal,
    weigh_by_step,
    weigh_by_violation,
)
from equipoise.hqp.solvers.active_set.primitives import (
    DEPENDENT,
    DEPENDENT_ROW,
    EQUALITY,
    FEASIBILITY,
    GOAL,
    HARD,
    LEFT,
    NEXT_V,
    NORM,
    ONCE_LEFT,
    ORDER,
    RANK_TOLERANCE,
    REST,
    ROLE,
    SCRATCH,
    SIDE,
    STEP,
    VALUE,
    VIOLATION,
    ZERO_TOLERANCE,
    Buffers,
    Level,
    Problem,
    V,
    Working,
    column,
    copy_row,
    dot,
    make_reflector,
    reflect,
    reflect_from,
)
from equipoise.hqp.solvers.active_set.projection import project

SUM_UP_AGAIN = 1e-3


@compiled
def solve_working(p: Problem, b: Buffers, level: Level) -> Working:
    """Solve the problem of the working rows; leave the step and the next v in the buffers."""
    n = b.of_columns.shape[1]
    hard = take_hard_rows(p, b, level)
    top = level.fixed + hard
    if level.weight > 0.0:
        reach_goal(b, level.fixed, hard)
        go(b, level.fixed, top, n)
        weigh_by_goal(b, level, hard)
        return Working(hard, hard, n - top, 0, False)
    equal, last = take_soft_rows(p, b, level, hard)
    equal_rank = eliminate(b, top, hard, equal, last)
    rank = equal_rank
    if equal < last:
        rank += eliminate(b, top + equal_rank, hard + equal_rank, last, last)
    met = reach_soft_rows(b, top, hard, last, rank, level.size)
    if met:
        weigh_by_step(b, level, hard, rank)
    else:
        weigh_by_violation(b, level, hard, last)
    go(b, level.fixed, top + rank, top + rank)
    return Working(hard, last, rank, equal_rank, met)


@compiled
def take_rows(p: Problem, b: Buffers, first: int, last: int, fixed: int, hard: int) -> None:
    """Fill the working rows at places first..last, their rest and the square of what is left.

    They are reflected by the `hard` rows before them, and the part of those of what they have to
    reach is gone.
    """
    project(b, first, last, fixed)
    factor, projected, reflectors, of_rows = b.factor, b.projected, b.reflectors, b.of_rows
    numbers, signs, columns = b.numbers, b.signs, b.of_columns
    n, top = factor.shape[1], fixed + hard
    for i in range(first, last):
        copy_row(factor, i, projected, numbers[ORDER, i])
    for j in range(fixed, top):
        for i in range(first, last):
            reflect(factor, i, reflectors, j, n)
    for i in range(first, last):
        row = numbers[ORDER, i]
        bound = p.upper[row] if signs[SIDE, row] > 0 else p.lower[row]
        reached = dot(factor, i, columns, STEP, fixed, top)
        of_rows[REST, i] = bound - of_rows[VALUE, row] - reached
        of_rows[LEFT, i] = dot(factor, i, factor, i, top, n)
        of_rows[ONCE_LEFT, i] = of_rows[LEFT, i]


@inlined
def take_hard_rows(p: Problem, b: Buffers, level: Level) -> int:
    """Eliminate the hard working rows; return their number.

    Dependent ones leave the set; the worst broken one of them is noted with its shares.
    """
    signs, order = b.signs, b.numbers
    order[DEPENDENT_ROW, 0] = -1
    last = 0
    for row in range(level.start):
        if signs[ROLE, row] == HARD and signs[SIDE, row] != 0:
            order[ORDER, last] = row
            last += 1
    if last == 0:
        return 0
    take_rows(p, b, 0, last, level.fixed, 0)
    rank = eliminate(b, level.fixed, 0, last, last)
    reach_in_turn(b, level.fixed, 0, rank)
    worst, most = -1, FEASIBILITY * level.size
    for i in range(rank, last):
        row = order[ORDER, i]
        value = b.of_rows[VALUE, row]
        value += dot(b.factor, i, b.of_columns, STEP, level.fixed, level.fixed + rank)
        beyond = max(value - p.upper[row], p.lower[row] - value) / b.of_rows[NORM, row]
        if beyond > most:
            worst, most = i, beyond
    if worst >= 0:
        share_out(b, level.fixed, rank, worst)
    for i in range(rank, last):
        signs[SIDE, order[ORDER, i]] = DEPENDENT
    return rank


@inlined
def take_soft_rows(p: Problem, b: Buffers, level: Level, hard: int) -> tuple[int, int]:
    """Append the soft working rows, equalities first; return where these and where all end."""
    signs, order = b.signs, b.numbers
    equal = hard
    for row in range(level.start, level.end):
        if signs[SIDE, row] == EQUALITY:
            order[ORDER, equal] = row
            equal += 1
    last = equal
    for row in range(level.start, level.end):
        if signs[SIDE, row] != 0 and signs[SIDE, row] != EQUALITY:
            order[ORDER, last] = row
            last += 1
    take_rows(p, b, hard, last, level.fixed, hard)
    return equal, last


@compiled
def eliminate(b: Buffers, top: int, first: int, until: int, last: int) -> int:
    """Eliminate working rows first..until from column `top` on, the largest first; return the rank.

    The rows up to `last` are reflected with them. What is left of a dependent row is set to zero.
    """
    factor, reflectors, of_rows, numbers = b.factor, b.reflectors, b.of_rows, b.numbers
    n, rank = factor.shape[1], 0
    while first + rank < until and top + rank < n:
        place, k = first + rank, top + rank
        best, most = -1, 0.0
        for i in range(place, until):
            if of_rows[LEFT, i] > most:
                best, most = i, of_rows[LEFT, i]
        if best < 0:
            break
        length = np.sqrt(dot(factor, best, factor, best, k, n))
        if length <= RANK_TOLERANCE * of_rows[NORM, numbers[ORDER, best]]:
            factor[best, k:] = 0.0
            of_rows[LEFT, best] = 0.0
            continue
        swap_places(b, place, best)
        factor[place, k] = make_reflector(factor, place, reflectors, k, n, length)
        for i in range(place + 1, last):
            if of_rows[LEFT, i] > 0.0:
                reflect(factor, i, reflectors, k, n)
        for i in range(place + 1, last):
            if of_rows[LEFT, i] > 0.0:
                of_rows[LEFT, i] -= factor[i, k] ** 2
                if of_rows[LEFT, i] <= SUM_UP_AGAIN * of_rows[ONCE_LEFT, i]:
                    of_rows[LEFT, i] = dot(factor, i, factor, i, k + 1, n)
                    of_rows[ONCE_LEFT, i] = of_rows[LEFT, i]
        rank += 1
    return rank


@inlined
def swap_places(b: Buffers, i: int, k: int) -> None:
    """Swap two working rows."""
    if i == k:
        return
    factor, order, of_rows = b.factor, b.numbers, b.of_rows
    for c in range(column(factor.shape[1])):
        factor[i, c], factor[k, c] = factor[k, c], factor[i, c]
    order[ORDER, i], order[ORDER, k] = order[ORDER, k], order[ORDER, i]
    of_rows[REST, i], of_rows[REST, k] = of_rows[REST, k], of_rows[REST, i]
    of_rows[LEFT, i], of_rows[LEFT, k] = of_rows[LEFT, k], of_rows[LEFT, i]
    once = of_rows[ONCE_LEFT, i]
    of_rows[ONCE_LEFT, i] = of_rows[ONCE_LEFT, k]
    of_rows[ONCE_LEFT, k] = once


@compiled
def reach_in_turn(b: Buffers, top: int, first: int, rank: int) -> None:
    """Solve the triangle of eliminated rows for their coordinates of the step."""
    factor, of_rows, steps = b.factor, b.of_rows, b.of_columns
    for i in range(first, first + rank):
        k = top + i - first
        rest = of_rows[REST, i] - dot(factor, i, steps, STEP, top, k)
        steps[STEP, k] = rest / factor[i, k]


@inlined
def reach_soft_rows(b: Buffers, top: int, first: int, last: int, rank: int, size: float) -> bool:
    """Solve the eliminated soft rows for the step; tell whether it meets all of them."""
    factor, of_rows, steps = b.factor, b.of_rows, b.of_columns
    for i in range(first, last):
        of_rows[VIOLATION, i] = 0.0
    reach_in_turn(b, top, first, rank)
    met = True
    for i in range(first + rank, last):
        beyond = dot(factor, i, steps, STEP, top, top + rank) - of_rows[REST, i]
        norm = of_rows[NORM, b.numbers[ORDER, i]]
        met = met and abs(beyond) <= ZERO_TOLERANCE * norm * size
    if not met:
        compromise(b, top, first, last, rank)
    return met


@compiled
def compromise(b: Buffers, top: int, first: int, last: int, rank: int) -> None:
    """Solve the eliminated soft rows for the step by least squares; fill their violation."""
    factor, triangle, of_rows, columns = b.factor, b.triangle, b.of_rows, b.of_columns
    rows = last - first
    for j in range(rank):
        for i in range(rows):
            triangle[j, i] = factor[first + i, top + j] if i >= j else 0.0
    for i in range(rows):
        of_rows[LEFT, i] = of_rows[REST, first + i]
    for j in range(rank):
        length = np.sqrt(dot(triangle, j, triangle, j, j, rows))
        columns[SCRATCH, j] = make_reflector(triangle, j, triangle, j, rows, length)
        for k in range(j + 1, rank):
            reflect_from(triangle, k, triangle, j, j, rows)
        reflect_from(of_rows, LEFT, triangle, j, j, rows)
    for j in range(rank - 1, -1, -1):
        rest = of_rows[LEFT, j]
        for k in range(j + 1, rank):
            rest -= triangle[k, j] * columns[STEP, top + k]
        columns[STEP, top + j] = rest / columns[SCRATCH, j]
        of_rows[LEFT, j] = 0.0
    for j in range(rank - 1, -1, -1):
        reflect_from(of_rows, LEFT, triangle, j, j, rows)
    for i in range(rows):
        of_rows[VIOLATION, first + i] = -of_rows[LEFT, i]


@compiled
def reach_goal(b: Buffers, fixed: int, hard: int) -> None:
    """Solve soft rows that are the unit matrix: go straight to the goal in what is free.

    Leaves as scratch how far the hard rows keep it from there, along their own reflectors.
    """
    columns, reflectors = b.of_columns, b.reflectors
    n = columns.shape[1]
    for c in range(n):
        columns[NEXT_V, c] = columns[GOAL, c] - columns[V, c]
    for j in range(fixed + hard):
        reflect(columns, NEXT_V, reflectors, j, n)
    for j in range(hard):
        columns[SCRATCH, j] = columns[STEP, fixed + j] - columns[NEXT_V, fixed + j]
    for c in range(fixed + hard, n):
        columns[STEP, c] = columns[NEXT_V, c]


@compiled
def go(b: Buffers, fixed: int, reflectors: int, stop: int) -> None:
    """Turn the coordinates fixed..stop of the step into the step, and go to the next v."""
    columns, u = b.of_columns, b.reflectors
    n = columns.shape[1]
    columns[STEP, :fixed] = 0.0
    columns[STEP, stop:] = 0.0
    for j in range(reflectors - 1, -1, -1):
        reflect(columns, STEP, u, j, n)
    for c in range(n):
        columns[NEXT_V, c] = columns[V, c] + columns[STEP, c]
