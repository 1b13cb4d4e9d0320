"""Compiled steps of a search: how far hard rows and the violation let it go, what changes there."""

from __future__ import annotations

from equipoise.compiled.compilation import compiled, inlined
from equipoise.compiled.workspace import Block, integers, vector
from equipoise.hqp.solvers.active_set.memory import (
    BASIS,
    EQUALITY,
    FEASIBILITY,
    FREE,
    HARD,
    LOWER,
    NEXT_V,
    NEXT_VALUE,
    NUMBERS,
    OWN,
    RATE,
    ROLE,
    ROUNDING,
    SIDE,
    STEP,
    UPPER,
    VALUE,
    V,
)
from equipoise.hqp.solvers.active_set.primitives import copy_vector, length
from equipoise.hqp.solvers.active_set.values import is_dependent, measure, norm_of, side_of

TURNS = 40  # of the search for the least violation along a step
LEVEL_ENOUGH = 1e-9  # share of the slope at the start that counts as none


@compiled
def take_violated(rows: Block, search: Block, start: int, end: int, size: float) -> bool:
    """Take the own equalities, and rows that v violates, to work; tell whether there were any."""
    low, high, value = vector(rows, LOWER), vector(rows, UPPER), vector(search, VALUE)
    role, side, changed = integers(search, ROLE), integers(search, SIDE), False
    for row in range(start, end):
        if role[row] != OWN or side[row] != 0:
            continue
        if low[row] == high[row]:
            side[row] = EQUALITY
        elif not (value[row] <= high[row] and value[row] >= low[row]):
            margin = FEASIBILITY * norm_of(rows, row) * size
            side[row] = side_of(low[row], high[row], value[row], margin)
        changed = changed or side[row] != 0
    return changed


@inlined
def take_met(rows: Block, search: Block, start: int, end: int, size: float) -> bool:
    """Take the own rows to work that stand at a bound and that the step leads beyond it."""
    low, high, value = vector(rows, LOWER), vector(rows, UPPER), vector(search, VALUE)
    next_value = vector(search, NEXT_VALUE)
    role, side, changed = integers(search, ROLE), integers(search, SIDE), False
    for row in range(start, end):
        if role[row] != OWN or side[row] != 0:
            continue
        if next_value[row] <= high[row] and next_value[row] >= low[row]:
            continue
        margin = FEASIBILITY * norm_of(rows, row) * size
        if next_value[row] > high[row] and value[row] >= high[row] - margin:
            side[row] = 1
        elif next_value[row] < low[row] and value[row] <= low[row] + margin:
            side[row] = -1
        changed = changed or side[row] != 0
    return changed


@compiled
def reach(rows: Block, search: Block, end: int, size: float, short: bool) -> tuple[float, int, int]:
    """Return the share of the step that is free, and the row and side that stop it (-1: none).

    Hard rows stop it, and own rows that do not work where steps are short.
    """
    low, high = vector(rows, LOWER), vector(rows, UPPER)
    value, next_value = vector(search, VALUE), vector(search, NEXT_VALUE)
    rates = vector(search, RATE)
    role, at_work = integers(search, ROLE), integers(search, SIDE)
    share, stop, side, steepest = 1.0, -1, 0, 0.0
    span = length(vector(search, STEP), vector(search, STEP).shape[0])
    for row in range(end):
        if at_work[row] != 0 or not (role[row] == HARD or (short and role[row] == OWN)):
            continue
        if next_value[row] <= high[row] and next_value[row] >= low[row]:
            continue
        if role[row] == HARD and low[row] == high[row]:  # depends on others, and is looked at last
            continue
        norm = norm_of(rows, row)
        rate = rates[row]
        if abs(rate) <= ROUNDING * norm * (span + size):
            continue
        if is_dependent(rows, search, BASIS, row, integers(search, NUMBERS)[FREE]):
            continue
        bound = high[row] if rate > 0.0 else low[row]
        rest = bound - value[row]
        near = abs(rest) <= FEASIBILITY * norm * size
        reached = 0.0 if near else max(rest / rate, 0.0)
        slope = abs(rate) / norm
        if reached < share or (reached == share and not short and slope > steepest):
            share, stop, steepest = reached, row, slope
            side = 1 if rate > 0.0 else -1
    return share, stop, side


@compiled
def least_along(rows: Block, search: Block, start: int, end: int, most: float) -> float:
    """Return the share of the step, at most `most`, up to which the violation falls."""
    begin, _ = slope_at(rows, search, start, end, 0.0)
    slope, bend = slope_at(rows, search, start, end, most)
    if not slope > LEVEL_ENOUGH * abs(begin):
        return most
    low, high, share = 0.0, most, most
    for _ in range(TURNS):
        share -= slope / bend
        if not low < share < high:
            share = 0.5 * (low + high)
        slope, bend = slope_at(rows, search, start, end, share)
        if abs(slope) <= LEVEL_ENOUGH * abs(begin):
            break
        if slope > 0.0:
            high = share
        else:
            low = share
    return share


@inlined
def slope_at(rows: Block, search: Block, start: int, end: int, share: float) -> tuple[float, float]:
    """Return the derivatives of half the squared violation along the step: first, second."""
    low, high, role = vector(rows, LOWER), vector(rows, UPPER), integers(search, ROLE)
    value, rates = vector(search, VALUE), vector(search, RATE)
    slope, bend = 0.0, 0.0
    for row in range(start, end):
        if role[row] == OWN:
            rate = rates[row]
            here = value[row] + share * rate
            beyond = here - min(max(here, low[row]), high[row])
            slope += beyond * rate
            if beyond != 0.0:
                bend += rate * rate
    return slope, bend


@inlined
def look_ahead(rows: Block, search: Block, end: int) -> None:
    """Fill the rates along the step, which keep all digits of it, and the values at its end."""
    value, next_value, rate = (
        vector(search, VALUE),
        vector(search, NEXT_VALUE),
        vector(search, RATE),
    )
    measure(rows, search, STEP, RATE, 0, end)
    for row in range(end):
        next_value[row] = value[row] + rate[row]


@inlined
def move(search: Block, share: float, end: int) -> None:
    """Go a share of the step; the values of hard and own rows go with it."""
    v, next_v, step = vector(search, V), vector(search, NEXT_V), vector(search, STEP)
    value, next_value = vector(search, VALUE), vector(search, NEXT_VALUE)
    rate = vector(search, RATE)
    if share >= 1.0:
        copy_vector(v, next_v, v.shape[0])
        copy_vector(value, next_value, end)
        return
    for c in range(v.shape[0]):
        v[c] += share * step[c]
    for row in range(end):
        value[row] += share * rate[row]
