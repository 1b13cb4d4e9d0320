"""Compiled search on one level: the violation of its rows falls from step to step.

From a v that meets all hard rows: solve the problem of the rows at work, go toward its optimum as
far as the hard rows allow and as long as the violation falls, past own rows that come in or go out;
at an optimum let the held row go that has most the wrong sign. Where steps become many it takes
them short, to the first row that changes, and rows by their numbers, so that it must end.
"""

from __future__ import annotations

from equipoise.compiled.compilation import compiled, inlined
from equipoise.compiled.workspace import Block, integers, vector
from equipoise.hqp.solvers.active_set.approach import approach
from equipoise.hqp.solvers.active_set.line import (
    least_along,
    look_ahead,
    move,
    reach,
    take_met,
    take_violated,
)
from equipoise.hqp.solvers.active_set.memory import (
    EQUALITY,
    FEASIBILITY,
    HELD,
    LOWER,
    MISS,
    MULTIPLIER,
    NEXT_V,
    NOISE,
    NUMBERS,
    PLACE,
    POINT,
    SHAKE,
    SIDE,
    SMALLEST,
    STEP,
    UPPER,
    VALUE,
    V,
)
from equipoise.hqp.solvers.active_set.primitives import copy_vector, length
from equipoise.hqp.solvers.active_set.values import measure, norm_of
from equipoise.hqp.solvers.active_set.working import solve_working, take_held

LONG_STEPS = 60  # working problems after which steps are short
FAR_AWAY = 10.0
STALLS = 15  # steps in a row that went nowhere, after which they are too


@compiled
def descend(
    rows: Block, search: Block, start: int, end: int, limit: int
) -> tuple[int, int, bool, bool]:
    """Search from v, which meets the hard rows; held are those of them that are at work.

    Returns where the soft rows of the last working problem end, their rank, whether they are all
    met, and whether the search ended by itself. The optimum is in v and in next_v.
    """
    v, next_v = vector(search, V), vector(search, NEXT_V)
    n, works, stalls, farthest = v.shape[0], 0, 0, 0.0
    size = max(length(v, n), SMALLEST)
    measure(rows, search, V, VALUE, 0, end)
    take_violated(rows, search, start, end, size)
    held_changed = True
    while True:
        tries = 0
        while held_changed and works + tries < LONG_STEPS:
            take_held(rows, search, start, max(length(v, n), SMALLEST))
            row, side = approach(rows, search, start, end)
            measure(rows, search, V, VALUE, 0, end)
            held_changed, tries = row >= 0, tries + 1
            if row >= 0:
                integers(search, SIDE)[row] = side
        held_changed = False
        last, rank, met, size = solve_working(rows, search, start, end)
        works += 1
        short = works > LONG_STEPS or stalls > STALLS
        look_ahead(rows, search, end)
        span = length(vector(search, STEP), n)
        still = span <= FEASIBILITY * max(length(v, n), SMALLEST)
        share, row, side = 1.0, -1, 0
        if not still:
            share, row, side = reach(rows, search, end, max(length(v, n), SMALLEST), short)
        if not (short or still):
            lower_share = least_along(rows, search, start, end, share)
            if lower_share < share:
                share, row = lower_share, -1
        whole = share >= 1.0 and row < 0
        move(search, share, end)
        size = size if whole else max(length(v, n), SMALLEST)
        farthest = max(farthest, size)
        stalls = 0 if share * span > FEASIBILITY * size else stalls + 1
        changed = release_soft(rows, search, last, size, whole, short)
        if not short:
            changed = take_violated(rows, search, start, end, size) or changed
            if share < 1.0:
                changed = take_met(rows, search, start, end, size) or changed
        if row >= 0:
            integers(search, SIDE)[row] = side
            held_changed = True
        if not whole and works < limit:
            continue
        if not changed and not met:
            held_changed = release_held(search, short)
        ended = not (changed or held_changed)
        if ended or works >= limit:
            break
    if farthest > FAR_AWAY * size:  # digits were lost on the way
        copy_vector(v, vector(search, POINT), n)
        last, rank, met, size = solve_working(rows, search, start, end)
        copy_vector(v, next_v, n)
    copy_vector(next_v, v, n)
    return last, rank, met, ended


@compiled
def release_soft(
    rows: Block, search: Block, last: int, size: float, whole: bool, short: bool
) -> bool:
    """Let own rows go that v is within the bounds of; tell whether there were any.

    After a whole step their violations are known to rounding, else by their values. Where steps are
    short only the one with the lowest number goes, after a whole step.
    """
    low, high, value = vector(rows, LOWER), vector(rows, UPPER), vector(search, VALUE)
    place, side, first = integers(search, PLACE), integers(search, SIDE), -1
    miss, shake = vector(search, MISS), vector(search, SHAKE)
    if short and not whole:
        return False
    for i in range(integers(search, NUMBERS)[HELD], last):
        row = place[i]
        if side[row] == EQUALITY:
            continue
        if whole:
            inside = miss[i] * side[row] < -shake[i]
        else:
            margin = FEASIBILITY * norm_of(rows, row) * size
            here = high[row] - value[row] if side[row] > 0 else value[row] - low[row]
            inside = here > margin
        if inside and not short:
            side[row] = 0
        if inside and (first < 0 or row < first):
            first = row
    if short and first >= 0:
        side[first] = 0
    return first >= 0


@inlined
def release_held(search: Block, short: bool) -> bool:
    """Let the held row go whose multiplier has most the wrong sign; tell whether there was one.

    Where steps are short, the one with the lowest number.
    """
    place, side = integers(search, PLACE), integers(search, SIDE)
    multiplier, noise = vector(search, MULTIPLIER), vector(search, NOISE)
    wrong, worst = -1, 0.0
    for j in range(integers(search, NUMBERS)[HELD]):
        row = place[j]
        push = -multiplier[j] * side[row]
        better = row < wrong if short else push > worst
        if side[row] != EQUALITY and push > noise[j] and (wrong < 0 or better):
            wrong, worst = row, push
    if wrong >= 0:
        side[wrong] = 0
    return wrong >= 0
