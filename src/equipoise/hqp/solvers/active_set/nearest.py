"""Compiled dual method: the point nearest to a goal under all hard rows, or that there is none.

The held rows keep multipliers of the right sign. The hard row that is most broken comes in; on the
way held rows whose multipliers reach zero go. Each row that has come in made the distance larger,
so that no set of held rows comes twice. Where the broken row is a sum of held rows and none of
these can give way, the hard rows contradict each other.

Source: Goldfarb and Idnani (1983), for the unit matrix. Differs from the print: starts from the
rows that were held last time, those with a wrong sign first let go.
"""

from __future__ import annotations

import numpy as np

from equipoise.compiled.compilation import compiled, inlined
from equipoise.compiled.workspace import Block, integers, matrix, vector
from equipoise.hqp.solvers.active_set.held import (
    hold,
    hold_remembered,
    let_go,
    most_wrong,
    solve_held,
    solve_transposed,
)
from equipoise.hqp.solvers.active_set.memory import (
    DEPENDENT,
    EQUALITY,
    FACTOR,
    FEASIBILITY,
    FREE,
    GOAL,
    HARD,
    HELD,
    LOWER,
    MET_TOLERANCE,
    MULTIPLIER,
    NEXT_V,
    NEXT_VALUE,
    NORM,
    NUMBERS,
    PLACE,
    REDUCED,
    REFLECTORS,
    ROLE,
    SHARE,
    SIDE,
    SMALLEST,
    UPPER,
    WORKS,
)
from equipoise.hqp.solvers.active_set.primitives import copy_row, dot, length, reflect
from equipoise.hqp.solvers.active_set.values import (
    is_dependent,
    measure,
    norm_of,
    reduce_row,
    side_of,
)

FOUND, CONTRADICTION, TOO_MANY = range(3)


@compiled
def find_nearest(rows: Block, search: Block, basis: int, number: int, end: int, limit: int) -> int:
    """Fill next_v with the point nearest to the goal under the hard rows before `end`.

    `number`: which memory of held rows to start from.
    """
    numbers, works = integers(search, NUMBERS), 0
    n = vector(search, NEXT_V).shape[0]
    hold_remembered(rows, search, basis, number, end)
    far = length(vector(search, GOAL), numbers[FREE])
    while True:
        solve_held(search, basis)
        works += 1
        numbers[WORKS] += 1
        size = max(length(vector(search, NEXT_V), n), SMALLEST)
        wrong = most_wrong(search, far + size)
        if wrong >= 0:
            if works > limit:
                return TOO_MANY
            let_go(rows, search, wrong)
            continue
        measure(rows, search, NEXT_V, NEXT_VALUE, 0, end)
        row = most_broken(rows, search, basis, end, size)
        if row < 0:
            return FOUND
        if works > limit:
            return TOO_MANY
        if not take_in(rows, search, basis, row, size):
            return CONTRADICTION


@compiled
def most_broken(rows: Block, search: Block, basis: int, end: int, size: float) -> int:
    """Return the hard row before `end` that is broken most for its length, -1 for none."""
    low, high, value = vector(rows, LOWER), vector(rows, UPPER), vector(search, NEXT_VALUE)
    role, side = integers(search, ROLE), integers(search, SIDE)
    broken, most, free = -1, 0.0, integers(search, NUMBERS)[FREE]
    for row in range(end):
        if role[row] != HARD or (value[row] <= high[row] and value[row] >= low[row]):
            continue
        if side[row] != 0:
            continue
        beyond = max(value[row] - high[row], low[row] - value[row])
        norm = norm_of(rows, row)
        if beyond <= FEASIBILITY * norm * size:
            continue
        if beyond <= MET_TOLERANCE * norm * size and (
            low[row] == high[row] or is_dependent(rows, search, basis, row, free)
        ):
            continue
        share = beyond / norm if norm > 0.0 else np.inf
        if not share <= most:
            broken, most = row, share
            if not share < np.inf:
                return row
    return broken


@compiled
def take_in(rows: Block, search: Block, basis: int, row: int, size: float) -> bool:
    """Hold a broken row, letting go of those whose multipliers reach zero on the way.

    Returns False where nothing can give way.
    """
    numbers, factor, multiplier = (
        integers(search, NUMBERS),
        matrix(search, FACTOR),
        vector(search, MULTIPLIER),
    )
    free, share = numbers[FREE], vector(search, SHARE)
    low, high = vector(rows, LOWER)[row], vector(rows, UPPER)[row]
    value = vector(search, NEXT_VALUE)[row]
    side = side_of(low, high, value, 0.0)
    beyond = max(value - high, low - value)
    reduce_row(rows, search, basis, row, free)
    norm = vector(search, NORM)[row]
    while True:
        held = numbers[HELD]
        spare = held  # there is one: the broken row is not held
        copy_row(factor, spare, matrix(search, REDUCED), row, free)
        for j in range(held):
            reflect(factor, spare, matrix(search, REFLECTORS), j, free)
        left = dot(factor, spare, factor, spare, held, free)
        independent = held < free and left > (DEPENDENT * norm) ** 2
        for k in range(held):
            share[k] = factor[spare, k]
        solve_transposed(factor, share, held)
        leaving, most = first_to_leave(search, side, norm)
        needed = beyond / left if independent else np.inf
        if leaving < 0 and not independent:
            return False
        if not needed > most:  # also where it is no number: nothing is let go for that
            break
        for k in range(held):
            multiplier[k] -= most * side * share[k]
        beyond -= most * left
        for k in range(leaving, held - 1):
            multiplier[k] = multiplier[k + 1]
        let_go(rows, search, leaving)
        if numbers[HELD] < held - 1:  # another one turned out to depend on the rest: start anew
            break
    return hold(rows, search, basis, row, EQUALITY if low == high else side)


@inlined
def first_to_leave(search: Block, side: int, norm: float) -> tuple[int, float]:
    """Return the place of the held inequality whose multiplier falls to zero first, and when.

    Rows enter the broken one by their shares; a share that is rounding is none.
    """
    place, own_side = integers(search, PLACE), integers(search, SIDE)
    multiplier, share, own_norm = (
        vector(search, MULTIPLIER),
        vector(search, SHARE),
        vector(search, NORM),
    )
    leaving, first = -1, np.inf
    for k in range(integers(search, NUMBERS)[HELD]):
        row = place[k]
        if own_side[row] == EQUALITY:
            continue
        falls = share[k] * side * own_side[row]
        if falls * own_norm[row] <= DEPENDENT * norm:
            continue
        when = max(multiplier[k] * own_side[row], 0.0) / falls
        if when < first:
            leaving, first = k, when
    return leaving, first
