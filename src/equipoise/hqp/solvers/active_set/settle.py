"""Compiled end of a level: what its optimum determines leaves the unknowns, the rest stays hard."""

from __future__ import annotations

from equipoise.compiled.compilation import compiled, inlined
from equipoise.compiled.workspace import Block, integer_matrix, integers, matrix, vector
from equipoise.hqp.solvers.active_set.elimination import eliminate_largest, span_rest
from equipoise.hqp.solvers.active_set.memory import (
    BASIS,
    BASIS_NUMBER,
    EQUALITY,
    FACTOR,
    FEASIBILITY,
    FIXED,
    FREE,
    HARD,
    HELD,
    MISS,
    MULTIPLIER,
    NOISE,
    NORM,
    NUMBERS,
    OWN,
    PLACE,
    POINT,
    REDUCED,
    ROLE,
    SHAKE,
    SIDE,
    SIDES,
    SQUARE,
    TURNED,
    V,
)
from equipoise.hqp.solvers.active_set.primitives import copy_row, copy_vector, length
from equipoise.hqp.solvers.active_set.reduction import learn, shrink
from equipoise.hqp.solvers.active_set.values import reduce_row


@compiled
def remember_sides(search: Block, number: int, end: int) -> None:
    """Keep for the next tick which rows before `end` worked, on which side."""
    role, side, sides = (
        integers(search, ROLE),
        integers(search, SIDE),
        integer_matrix(search, SIDES),
    )
    for row in range(end):
        at_work = role[row] == HARD or role[row] == OWN
        sides[number, row] = side[row] if at_work else 0


@compiled
def settle(
    rows: Block, search: Block, start: int, end: int, last: int, rank: int, decided: bool
) -> None:
    """Fix what the optimum of the own rows start..end determines, keep the other rows as hard ones.

    Equalities, violated rows and held rows with a multiplier are determined; `decided` says whether
    there are violations that tell. v becomes the point where we stand.
    """
    numbers, role = integers(search, NUMBERS), integers(search, ROLE)
    free, held = numbers[FREE], numbers[HELD]
    copy_vector(vector(search, POINT), vector(search, V), vector(search, V).shape[0])
    loose = fix(search, held, last, decided)
    count = held + rank
    if loose:
        count = eliminate_fixed(rows, search, last, free)
    if not decided:
        learn(rows, search, start, end, 0, count)
    for row in range(start, end):
        if role[row] == OWN:
            role[row] = HARD
    if count > 0:
        turned = vector(search, TURNED)
        for k in range(free):
            turned[k] = 0.0
        span_rest(search, SQUARE, count, free)
        shrink(search, count, free)
        numbers[BASIS_NUMBER] += 1


@inlined
def fix(search: Block, held: int, last: int, decided: bool) -> bool:
    """Give the determined rows at work their role; tell whether others are at work too."""
    role, side, place = integers(search, ROLE), integers(search, SIDE), integers(search, PLACE)
    miss, shake = vector(search, MISS), vector(search, SHAKE)
    multiplier, noise = vector(search, MULTIPLIER), vector(search, NOISE)
    v, norm, loose = vector(search, V), vector(search, NORM), False
    size = length(v, v.shape[0])
    for j in range(held):
        if decided and abs(multiplier[j]) > noise[j]:
            role[place[j]] = FIXED
        else:
            loose = True
    for i in range(held, last):
        margin = max(shake[i], FEASIBILITY * norm[place[i]] * size)
        if side[place[i]] == EQUALITY or (decided and abs(miss[i]) > margin):
            role[place[i]] = FIXED
        else:
            loose = True
    return loose


@inlined
def eliminate_fixed(rows: Block, search: Block, last: int, free: int) -> int:
    """Eliminate only the determined ones among the working rows; return their rank."""
    role, place, count = integers(search, ROLE), integers(search, PLACE), 0
    for i in range(last):
        row = place[i]
        if role[row] == FIXED:
            place[count] = row
            reduce_row(rows, search, BASIS, row, free)
            copy_row(matrix(search, FACTOR), count, matrix(search, REDUCED), row, free)
            count += 1
    return eliminate_largest(search, 0, 0, count, count, free, True)
