"""Compiled solution of one working problem: held hard rows first, then least squares of soft ones.

All in coordinates of the basis, as a step from v. The held rows take the first reflectors, the soft
working rows those after, the largest first.
"""

from __future__ import annotations

import numpy as np

from equipoise.compiled.compilation import compiled, inlined
from equipoise.compiled.workspace import Block, integers, matrix, vector
from equipoise.hqp.solvers.active_set.elimination import (
    eliminate_largest,
    reach_in_turn,
    turn_back,
)
from equipoise.hqp.solvers.active_set.held import inverse_column, solve_transposed
from equipoise.hqp.solvers.active_set.least_squares import solve_soft
from equipoise.hqp.solvers.active_set.memory import (
    ALONG,
    BASIS,
    FACTOR,
    FEASIBILITY,
    FREE,
    HARD,
    HELD,
    MISS,
    MULTIPLIER,
    NEXT_V,
    NOISE,
    NORM,
    NUMBERS,
    OWN,
    PLACE,
    REDUCED,
    REFLECTORS,
    REST,
    ROLE,
    ROUNDING,
    SHAKE,
    SIDE,
    SMALLEST,
    STEP,
    TURNED,
    WORKS,
    V,
)
from equipoise.hqp.solvers.active_set.primitives import (
    column,
    copy_row,
    dot_vector,
    length,
    reflect,
)
from equipoise.hqp.solvers.active_set.values import bound_of, reduce_row, value_of

FAR_FROM_ROUNDING = 1e6


@compiled
def solve_working(rows: Block, search: Block, start: int, end: int) -> tuple[int, int, bool, float]:
    """Solve for the rows at work among the hard ones and the own ones, start..end.

    Leaves the step from v, the next v, the violations and the multipliers of the held rows. Returns
    where the soft rows end, their rank, whether they are all met, and the size of v.
    """
    numbers, n = integers(search, NUMBERS), vector(search, V).shape[0]
    free = numbers[FREE]
    size = max(length(vector(search, V), n), SMALLEST)
    held = take_held(rows, search, start, size)
    last = take_soft(rows, search, start, end, held)
    rank = eliminate_largest(search, held, held, last, last, free, False)
    take_off(search, held, last)
    met, size = solve_soft(search, held, last, rank, size)
    go(search, held + rank)
    numbers[WORKS] += 1
    missed = 0.0
    for i in range(held, last):
        missed += abs(vector(search, MISS)[i])
    if not missed < np.inf:  # numbers that are none must not go unnoticed
        vector(search, NEXT_V)[0] = np.nan
    size = max(size, length(vector(search, NEXT_V), n))
    if not met:
        weigh(search, held, last, size)
    return last, rank, met, size


@compiled
def take_held(rows: Block, search: Block, start: int, size: float) -> int:
    """Eliminate the hard rows at work; return their number. Dependent ones stop working.

    A row that is at its bound to rounding is held where it is: to move it might break another.
    """
    rest, norm = vector(search, REST), vector(search, NORM)
    role, side, place = integers(search, ROLE), integers(search, SIDE), integers(search, PLACE)
    numbers, last = integers(search, NUMBERS), 0
    free = numbers[FREE]
    for row in range(start):
        if role[row] == HARD and side[row] != 0:
            place[last] = row
            take(rows, search, last, free)
            if abs(rest[last]) <= FEASIBILITY * norm[row] * size:
                rest[last] = 0.0
            last += 1
    held = eliminate_largest(search, 0, 0, last, last, free, True) if last > 0 else 0
    for i in range(held, last):
        side[place[i]] = 0
    numbers[HELD] = held
    reach_in_turn(search, 0, 0, held)
    return held


@inlined
def take_soft(rows: Block, search: Block, start: int, end: int, held: int) -> int:
    """Take the own rows at work, reflected by the held ones; return where they end."""
    role, side, place = integers(search, ROLE), integers(search, SIDE), integers(search, PLACE)
    factor, u, free = (
        matrix(search, FACTOR),
        matrix(search, REFLECTORS),
        integers(search, NUMBERS)[FREE],
    )
    last = held
    for row in range(start, end):
        if role[row] == OWN and side[row] != 0:
            place[last] = row
            take(rows, search, last, free)
            last += 1
    for j in range(held):
        for i in range(held, last):
            reflect(factor, i, u, j, free)
    return last


@compiled
def take(rows: Block, search: Block, i: int, free: int) -> None:
    """Write the row at a working place into the factor, and what it has to reach."""
    row = integers(search, PLACE)[i]
    reduce_row(rows, search, BASIS, row, free)
    copy_row(matrix(search, FACTOR), i, matrix(search, REDUCED), row, free)
    bound = bound_of(rows, row, integers(search, SIDE)[row])
    vector(search, REST)[i] = bound - value_of(rows, row, vector(search, V))


@inlined
def take_off(search: Block, held: int, last: int) -> None:
    """Take from the rest of the soft rows what the step to the held rows does to them."""
    rest, factor, along = vector(search, REST), matrix(search, FACTOR), vector(search, ALONG)
    for i in range(held, last):
        rest[i] -= dot_vector(factor, i, along, 0, held)


@compiled
def go(search: Block, count: int) -> None:
    """Turn coordinates along `count` reflectors into the step, and go from v to the next v."""
    numbers, turned, along = (
        integers(search, NUMBERS),
        vector(search, TURNED),
        vector(search, ALONG),
    )
    step, next_v, v, Z = (
        vector(search, STEP),
        vector(search, NEXT_V),
        vector(search, V),
        matrix(search, BASIS),
    )
    free, n = numbers[FREE], v.shape[0]
    for j in range(free):
        turned[j] = along[j] if j < count else 0.0
    turn_back(search, count, free)
    for c in range(n):
        step[c] = 0.0
    for k in range(free):
        scale = turned[k]
        for c in range(column(n)):
            step[c] += scale * Z[k, c]
    for c in range(n):
        next_v[c] = v[c] + step[c]


@inlined
def weigh(search: Block, held: int, last: int, size: float) -> None:
    """Fill the multipliers of the held rows and their rounding, from the violations."""
    factor, miss, shake = matrix(search, FACTOR), vector(search, MISS), vector(search, SHAKE)
    multiplier, noise = vector(search, MULTIPLIER), vector(search, NOISE)
    norm, place = vector(search, NORM), integers(search, PLACE)
    if held == 0:
        return
    rounding, least = 0.0, np.inf
    for j in range(held):
        multiplier[j] = 0.0
        least = min(least, abs(factor[j, j]))
    for i in range(held, last):
        rounding += norm[place[i]] * (shake[i] + ROUNDING * abs(miss[i]))
        for j in range(held):
            multiplier[j] -= miss[i] * factor[i, j]
    solve_transposed(factor, multiplier, held)
    for j in range(held):
        noise[j] = rounding / least
        if abs(multiplier[j]) < FAR_FROM_ROUNDING * noise[j]:
            noise[j] = rounding * inverse_column(search, held, j)
