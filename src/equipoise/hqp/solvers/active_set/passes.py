"""Compiled loop over the levels: those that can be met are merged, the others are stops.

Where all levels between two stops can be met, the optimum of the second is that of its rows under
all of theirs as hard rows: they need not be solved one by one. Stops are the levels that fell short
within the last ticks, the levels of unit rows (goals), and last the least norm. Where merged levels
turn out to contradict each other the loop begins again with each of them a stop.
"""

from __future__ import annotations

import numpy as np

from equipoise.compiled.compilation import inlined
from equipoise.compiled.workspace import Block, integers, matrix, vector
from equipoise.hqp.solvers.active_set.goal import is_goal, nearest_to_zero, whiten
from equipoise.hqp.solvers.active_set.level import ENDED, IMPOSSIBLE, solve_level
from equipoise.hqp.solvers.active_set.memory import (
    A_ROWS,
    BASIS,
    BASIS_NUMBER,
    COUNTS,
    ENDS,
    FREE,
    FRESH,
    INDEPENDENT,
    ITERATION_LIMIT,
    KNOWN,
    LATER,
    LOWER,
    MET,
    MET_LONG,
    NEXT_V,
    NUMBERS,
    ORDER,
    OUT,
    OWN,
    PASSES,
    POINT,
    RELEARN,
    RESTARTS,
    ROLE,
    SIDE,
    SOLVED,
    UPPER,
    WHITE,
    WORKS,
    V,
)
from equipoise.hqp.solvers.active_set.nearest import FOUND, find_nearest
from equipoise.hqp.solvers.active_set.primitives import copy_vector
from equipoise.hqp.solvers.active_set.reduction import merge, order_independent, write_unit_basis
from equipoise.hqp.solvers.active_set.settle import remember_sides, settle

AGAIN = -1  # an outcome: begin again, with more stops


@inlined
def solve_levels(rows: Block, search: Block, limit: int) -> int:
    """Solve all levels and the least norm; return how it ended. The answer is in v."""
    numbers, known = integers(search, NUMBERS), integers(search, KNOWN)
    numbers[WORKS], numbers[RESTARTS], numbers[RELEARN] = 0, 0, 0
    numbers[BASIS_NUMBER] = 0
    if known[0] == 0:
        integers(search, MET)[:] = 0
        integers(search, ORDER)[:] = -1
    prepare(rows, search)
    outcome = AGAIN
    while outcome == AGAIN:
        begin(search)
        outcome = visit_stops(rows, search, limit)
        numbers[RESTARTS] += outcome == AGAIN
    if numbers[RELEARN] != 0 or known[0] == 0:
        order_independent(rows, search)
    known[0] = 1
    return outcome


@inlined
def prepare(rows: Block, search: Block) -> None:
    """Give each row that counts and has a bound the role of one of a later level."""
    low, high, counts = vector(rows, LOWER), vector(rows, UPPER), integers(search, COUNTS)
    role = integers(search, ROLE)
    independent, order = integers(search, INDEPENDENT), integers(search, ORDER)
    for row in range(low.shape[0]):
        free = counts[row] == 0 or (low[row] == -np.inf and high[row] == np.inf)
        role[row] = OUT if free else LATER
        independent[row] = 0
    for row in order:
        if row >= 0:
            independent[row] = 1


@inlined
def begin(search: Block) -> None:
    """Stand at zero with all directions free."""
    numbers, role, side = integers(search, NUMBERS), integers(search, ROLE), integers(search, SIDE)
    point, fresh = vector(search, POINT), integers(search, FRESH)
    for c in range(point.shape[0]):
        point[c] = 0.0
    for row in range(role.shape[0]):
        side[row] = 0
        if role[row] != OUT:
            role[row] = LATER
    numbers[FREE], numbers[PASSES] = -1, 0
    if numbers[BASIS_NUMBER] == 0:
        for row in range(role.shape[0]):
            fresh[row] = 0


@inlined
def visit_stops(rows: Block, search: Block, limit: int) -> int:
    """Go from stop to stop; return how it ended."""
    ends, numbers = integers(rows, ENDS), integers(search, NUMBERS)
    met, levels, m = integers(search, MET), ends.shape[0], vector(rows, LOWER).shape[0]
    merged, first, outcome = 0, 0, SOLVED  # rows and levels before these are done with
    merging = False
    for number in range(levels + 1):
        start = ends[number - 1] if number > 0 else 0
        end = ends[number] if number < levels else m
        if number < levels and start == end:
            continue
        goal = number == levels or is_goal(rows, search, start, end)
        if not goal and met[number] >= MET_LONG:
            continue
        together = merged < start
        merging = merging or together
        if together:
            merge(rows, search, merged, start)
        write_unit_basis(search, matrix(rows, A_ROWS).shape[1])
        numbers[PASSES] += 1
        if numbers[FREE] == 0 and not together:
            break
        result = AGAIN
        if goal:
            result = visit_goal(rows, search, number, start, end, limit)
        if result == AGAIN and start < end and not (goal and together):
            result = visit_level(rows, search, number, start, end, together, limit)
        if result == AGAIN and merging:
            for level in range(first if together else 0, number):
                met[level] = 0
            return AGAIN
        if result != SOLVED:
            outcome = ITERATION_LIMIT
        merged, first = end, number + 1
        if numbers[FREE] == 0:
            break
    copy_vector(vector(search, V), vector(search, POINT), vector(search, V).shape[0])
    return outcome


@inlined
def visit_goal(rows: Block, search: Block, number: int, start: int, end: int, limit: int) -> int:
    """Go to the nearest point to a goal, or to zero for the least norm (no rows)."""
    numbers, basis = integers(search, NUMBERS), BASIS
    if start == end:
        nearest_to_zero(search)
    elif whiten(rows, search, start, end):
        basis = WHITE
    else:
        return AGAIN
    result = find_nearest(rows, search, basis, number, start, limit)
    numbers[BASIS_NUMBER] += 1
    if result != FOUND:
        return AGAIN
    remember_sides(search, number, start)
    copy_vector(vector(search, POINT), vector(search, NEXT_V), vector(search, V).shape[0])
    numbers[FREE] = 0
    return SOLVED


@inlined
def visit_level(
    rows: Block, search: Block, number: int, start: int, end: int, together: bool, limit: int
) -> int:
    """Minimise the violation of a level, and fix what that determines."""
    role = integers(search, ROLE)
    for row in range(start, end):
        if role[row] != OUT:
            role[row] = OWN
    how, last, rank, all_met = solve_level(rows, search, number, start, end, together, limit)
    if how == IMPOSSIBLE:
        return AGAIN
    remember_sides(search, number, end)
    settle(rows, search, start, end, last, rank, how == ENDED and not all_met)
    count_met(search, number, all_met)
    return SOLVED if how == ENDED else ITERATION_LIMIT


@inlined
def count_met(search: Block, number: int, all_met: bool) -> None:
    """Count the ticks in a row that a level was met; the first tick counts as many."""
    met = integers(search, MET)
    if not all_met:
        met[number] = 0
    elif integers(search, KNOWN)[0] == 0:
        met[number] = MET_LONG
    else:
        met[number] = min(met[number] + 1, MET_LONG)
