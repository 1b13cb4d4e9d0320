"""Compiled solution of a level that may not be met: guesses first, then the search that must end.

The rows that worked last time are tried first, and those that disagree flipped, all at once.
Guesses are few: what they leave open, the search takes up from the point nearest to the last answer
that meets the hard rows.
"""

from __future__ import annotations

import numpy as np

from equipoise.compiled.compilation import compiled, inlined
from equipoise.compiled.workspace import Block, integer_matrix, integers, vector
from equipoise.hqp.solvers.active_set.descent import descend
from equipoise.hqp.solvers.active_set.goal import nearest_to_last
from equipoise.hqp.solvers.active_set.memory import (
    BASIS,
    EQUALITY,
    FEASIBILITY,
    FREE,
    HARD,
    HELD,
    LOWER,
    MET_TOLERANCE,
    MISS,
    MULTIPLIER,
    NEXT_V,
    NEXT_VALUE,
    NOISE,
    NUMBERS,
    OWN,
    PLACE,
    POINT,
    ROLE,
    SHAKE,
    SIDE,
    SIDES,
    UPPER,
    V,
)
from equipoise.hqp.solvers.active_set.nearest import FOUND, find_nearest
from equipoise.hqp.solvers.active_set.primitives import copy_vector, length
from equipoise.hqp.solvers.active_set.values import (
    is_dependent,
    measure,
    norm_of,
    side_of,
    usable_side,
    value_of,
)
from equipoise.hqp.solvers.active_set.working import solve_working

GUESSES = 2
FEW = 3  # rows that disagree with a guess: with more of them another one would be as wrong
ENDED, STOPPED, IMPOSSIBLE = range(3)  # impossible: not all levels above can be met


@compiled
def solve_level(
    rows: Block, search: Block, number: int, start: int, end: int, merged: bool, limit: int
) -> tuple[int, int, int, bool]:
    """Minimise the violation of the own rows start..end under the hard rows before them.

    `merged`: that these can be met is not known. Returns how it ended, where the soft rows of the
    last working problem end, their rank, and whether they are met. The optimum is in v.
    """
    v, next_v, point = vector(search, V), vector(search, NEXT_V), vector(search, POINT)
    n = v.shape[0]
    copy_vector(v, point, n)
    remember(rows, search, number, start, end)
    least_size = np.inf
    for _ in range(min(GUESSES, limit)):
        last, rank, met, size = solve_working(rows, search, start, end)
        least_size = min(least_size, size)
        measure(rows, search, NEXT_V, NEXT_VALUE, 0, end)
        broken = hold_broken(rows, search, start, size)
        changed = flip_own(rows, search, start, end, last, size)
        if not (broken or met):
            changed += drop_wrong(search)
        if not broken and changed == 0:
            copy_vector(v, next_v, n)
            return ENDED, last, rank, met
        if changed > FEW:
            break
    nearest_to_last(search, least_size)
    if find_nearest(rows, search, BASIS, number, start, limit) == FOUND:
        copy_vector(v, next_v, n)
    elif merged:
        return IMPOSSIBLE, 0, 0, False
    else:
        copy_vector(v, point, n)
        forget(search, 0, start)
    forget(search, start, end)
    last, rank, met, ended = descend(rows, search, start, end, limit)
    if any_broken(rows, search, start):
        return IMPOSSIBLE, 0, 0, False
    return ENDED if ended else STOPPED, last, rank, met


@inlined
def remember(rows: Block, search: Block, number: int, start: int, end: int) -> None:
    """Put the hard and own rows to work that did so last time, and all own equalities."""
    role, side, sides = (
        integers(search, ROLE),
        integers(search, SIDE),
        integer_matrix(search, SIDES),
    )
    low, high = vector(rows, LOWER), vector(rows, UPPER)
    for row in range(end):
        if role[row] != HARD and role[row] != OWN:
            continue
        side[row] = 0
        if role[row] == OWN and low[row] == high[row]:
            side[row] = EQUALITY
        elif sides[number, row] != 0:
            side[row] = usable_side(rows, row, sides[number, row])


@inlined
def forget(search: Block, start: int, end: int) -> None:
    """Take the hard and own rows start..end from work."""
    role, side = integers(search, ROLE), integers(search, SIDE)
    for row in range(start, end):
        if role[row] == HARD or role[row] == OWN:
            side[row] = 0


@inlined
def hold_broken(rows: Block, search: Block, start: int, size: float) -> bool:
    """Put the hard rows to work that the next v breaks; tell whether there were any."""
    low, high, value = vector(rows, LOWER), vector(rows, UPPER), vector(search, NEXT_VALUE)
    role, side, broken = integers(search, ROLE), integers(search, SIDE), False
    free = integers(search, NUMBERS)[FREE]
    for row in range(start):
        if role[row] != HARD or side[row] != 0:
            continue
        if value[row] <= high[row] and value[row] >= low[row]:
            continue
        scale, equal = norm_of(rows, row) * size, low[row] == high[row]
        broken_side = side_of(low[row], high[row], value[row], FEASIBILITY * scale)
        if broken_side != 0 and (equal or is_dependent(rows, search, BASIS, row, free)):
            broken_side = side_of(low[row], high[row], value[row], MET_TOLERANCE * scale)
        if broken_side != 0:
            side[row] = EQUALITY if equal else broken_side
            broken = True
    return broken


@inlined
def any_broken(rows: Block, search: Block, start: int) -> bool:
    """Tell whether v breaks an equality before `start` that was left out as dependent on others."""
    low, high = vector(rows, LOWER), vector(rows, UPPER)
    role, v = integers(search, ROLE), vector(search, V)
    size = length(v, v.shape[0])
    for row in range(start):
        if role[row] == HARD and low[row] == high[row]:
            beyond = abs(value_of(rows, row, v) - low[row])
            if beyond > 0.0 and not beyond <= MET_TOLERANCE * norm_of(rows, row) * size:
                return True
    return False


@inlined
def flip_own(rows: Block, search: Block, start: int, end: int, last: int, size: float) -> int:
    """Put own rows to work that the next v violates, let those go that it does not; count them."""
    low, high, value = vector(rows, LOWER), vector(rows, UPPER), vector(search, NEXT_VALUE)
    place, role, side = integers(search, PLACE), integers(search, ROLE), integers(search, SIDE)
    miss, shake, changed = vector(search, MISS), vector(search, SHAKE), 0
    for row in range(start, end):
        if role[row] != OWN or side[row] != 0:
            continue
        if not (value[row] <= high[row] and value[row] >= low[row]):
            margin = FEASIBILITY * norm_of(rows, row) * size
            side[row] = side_of(low[row], high[row], value[row], margin)
            changed += side[row] != 0
    for i in range(integers(search, NUMBERS)[HELD], last):
        row = place[i]
        if side[row] != EQUALITY and miss[i] * side[row] < -shake[i]:
            side[row] = side_of(low[row], high[row], value[row], 0.0)
            changed += 1
    return changed


@inlined
def drop_wrong(search: Block) -> int:
    """Let all held rows go whose multipliers have the wrong sign; count them."""
    place, side = integers(search, PLACE), integers(search, SIDE)
    multiplier, noise, changed = vector(search, MULTIPLIER), vector(search, NOISE), 0
    for j in range(integers(search, NUMBERS)[HELD]):
        row = place[j]
        if side[row] != EQUALITY and multiplier[j] * side[row] < -noise[j]:
            side[row] = 0
            changed += 1
    return changed
