"""Compiled search for the right working rows of a level.

A row has a role: 0 belongs to a later level, OWN to the level at hand, HARD is a satisfied row of a
solved level, FIXED is one that the optimum of a solved level determines, FREE has no bound. Its
side is the bound at which it works: +1 upper, -1 lower, 2 equality, 0 not working.

A level first tries to guess: solve the working problem, flip every row that disagrees, again. If
that does not settle it searches anew by the primal method, which keeps the hard rows met, lowers
the violation at each step and takes the lowest row number when it stalls, so that it must end.
"""

from __future__ import annotations

import numpy as np

from equipoise.compiled.compilation import compiled, inlined
from equipoise.hqp.solvers.active_set.primitives import (
    DEPENDENT,
    DEPENDENT_ROW,
    EQUALITY,
    FEASIBILITY,
    HARD,
    MULTIPLIER,
    NEXT_V,
    NEXT_VALUE,
    NOISE,
    NORM,
    ORDER,
    OWN,
    RANK_TOLERANCE,
    ROLE,
    ROUNDING,
    SHARE,
    SIDE,
    SINGLE,
    SOFT_MULTIPLIER,
    STEP,
    VALUE,
    VIOLATION,
    ZERO_TOLERANCE,
    Buffers,
    Level,
    Problem,
    V,
    Working,
    copy_row,
    dot,
)
from equipoise.hqp.solvers.active_set.working import solve_working

GUESSES = 12
STALLS_BEFORE_LOWEST = 20


@inlined
def value_of(p: Problem, b: Buffers, row: int, point: int) -> float:
    """Return a row of A times a point."""
    A, columns = p.A, b.of_columns
    place = b.numbers[SINGLE, row]
    if place >= 0:
        return A[row, place] * columns[point, place]
    return dot(A, row, columns, point, 0, A.shape[1])


@compiled
def measure(p: Problem, b: Buffers, point: int, values: int, start: int, end: int) -> None:
    """Fill a row of values with A v for the hard and own rows start..end."""
    signs, of_rows = b.signs, b.of_rows
    for row in range(start, end):
        if signs[ROLE, row] == HARD or signs[ROLE, row] == OWN:
            of_rows[values, row] = value_of(p, b, row, point)


@inlined
def side_of(p: Problem, row: int, value: float, margin: float) -> int:
    """Return the side on which a value is beyond its bounds by more than a margin, or 0."""
    if value > p.upper[row] + margin:
        return 1
    return -1 if value < p.lower[row] - margin else 0


@inlined
def guess(p: Problem, b: Buffers, level: Level) -> tuple[Working, int, bool]:
    """Solve and flip until nothing disagrees, a few times; return the work and whether it did."""
    work = 0
    while True:
        working = solve_working(p, b, level)
        work += 1
        measure(p, b, NEXT_V, NEXT_VALUE, 0, level.end)
        flips = hold_broken(p, b, level, working)
        if flips > 0 or not working.met:
            flips += release_wrong(p, b, level, working)
        if flips == 0:
            return working, work, True
        if work == GUESSES:
            return working, work, False


@compiled
def hold_broken(p: Problem, b: Buffers, level: Level, working: Working) -> int:
    """Take broken hard rows and violated own rows into the working rows; count them."""
    signs, of_rows = b.signs, b.of_rows
    chosen, flips = b.numbers[DEPENDENT_ROW, 0], 0
    if chosen >= 0:
        give_way(p, b, level, working, chosen)
        signs[SIDE, chosen] = 0
    for row in range(level.end):
        if signs[ROLE, row] != HARD and signs[ROLE, row] != OWN:
            continue
        if signs[SIDE, row] == DEPENDENT:
            signs[SIDE, row] = 0
        elif signs[SIDE, row] == 0:
            margin = FEASIBILITY * of_rows[NORM, row] * level.size
            signs[SIDE, row] = side_of(p, row, of_rows[NEXT_VALUE, row], margin)
            flips += signs[SIDE, row] != 0
    return flips


@compiled
def release_wrong(p: Problem, b: Buffers, level: Level, working: Working) -> int:
    """Take rows that hold on the wrong side out of the working rows; count them.

    Where the soft rows are met, no row is wrong for that; but those that the least step does not
    need would only stand in the way of the broken ones.
    """
    signs, of_rows, columns = b.signs, b.of_rows, b.of_columns
    flips = 0
    for j in range(working.hard):
        row = b.numbers[ORDER, j]
        if columns[MULTIPLIER, j] * signs[SIDE, row] < -columns[NOISE, j]:
            signs[SIDE, row] = 0
            flips += 1
    for i in range(working.hard, working.last):
        row = b.numbers[ORDER, i]
        if signs[SIDE, row] == EQUALITY:
            continue
        margin = ZERO_TOLERANCE * of_rows[NORM, row] * level.size
        pull = of_rows[VIOLATION, i]
        if working.met:
            margin = ROUNDING * level.size / of_rows[NORM, row]
            rank = i - working.hard
            pull = columns[SOFT_MULTIPLIER, rank] if rank < working.rank else 0.0
        if pull * signs[SIDE, row] < -margin:
            signs[SIDE, row] = side_of(p, row, of_rows[NEXT_VALUE, row], 0.0)
            flips += 1
    return flips


@inlined
def give_way(p: Problem, b: Buffers, level: Level, working: Working, chosen: int) -> None:
    """Let go of the hard working row that stands in the way of a broken dependent one.

    The dependent row is a sum of working rows: only where one enters with its own sign does its
    leaving help, and the one whose multiplier falls to zero first keeps the others' signs right.
    """
    signs, of_rows, columns = b.signs, b.of_rows, b.of_columns
    side = side_of(p, chosen, of_rows[NEXT_VALUE, chosen], 0.0)
    best, least, largest = -1, np.inf, 0.0
    for j in range(working.hard):
        row = b.numbers[ORDER, j]
        share = columns[SHARE, j] * side * signs[SIDE, row]
        if share * of_rows[NORM, row] <= RANK_TOLERANCE * of_rows[NORM, chosen]:
            continue
        ratio = 0.0
        if not working.met:
            ratio = max(columns[MULTIPLIER, j] * signs[SIDE, row] - columns[NOISE, j], 0.0) / share
        if ratio < least or (ratio == least and share * of_rows[NORM, row] > largest):
            best, least, largest = row, ratio, share * of_rows[NORM, row]
    if best >= 0:
        signs[SIDE, best] = 0


@inlined
def search(p: Problem, b: Buffers, level: Level, limit: int) -> tuple[Working, int, bool]:
    """Search by the primal method from v; return the work and whether it ended by itself."""
    signs, columns = b.signs, b.of_columns
    signs[SIDE, : level.start] = 0
    for row in range(level.start, level.end):
        if signs[SIDE, row] == 0:
            signs[SIDE, row] = side_of(p, row, b.of_rows[VALUE, row], 0.0)
    n, work, stalls = columns.shape[1], 0, 0
    while True:
        working = solve_working(p, b, level)
        work += 1
        lowest = stalls > STALLS_BEFORE_LOWEST
        forget_dependent(b, level)
        share, row, side = reach(p, b, level, lowest)
        for c in range(n):
            columns[V, c] += share * columns[STEP, c]
        measure(p, b, V, VALUE, 0, level.end)
        length = share * np.sqrt(dot(columns, STEP, columns, STEP, 0, n))
        stalls = 0 if length > FEASIBILITY * level.size else stalls + 1
        ended = False
        if row >= 0:
            signs[SIDE, row] = side
        else:
            ended = not let_go(p, b, level, working, lowest)
        if ended or work >= limit:
            copy_row(columns, NEXT_V, columns, V)
            return working, work, ended


@inlined
def forget_dependent(b: Buffers, level: Level) -> None:
    """Take dependent hard rows out of the working rows."""
    for row in range(level.start):
        if b.signs[SIDE, row] == DEPENDENT:
            b.signs[SIDE, row] = 0


@compiled
def reach(p: Problem, b: Buffers, level: Level, lowest: bool) -> tuple[float, int, int]:
    """Return the share of the step that is free, and the row and side that stop it (-1: none)."""
    A, signs, of_rows, columns = p.A, b.signs, b.of_rows, b.of_columns
    n = A.shape[1]
    length = np.sqrt(dot(columns, STEP, columns, STEP, 0, n))
    share, stop, side, steepest = 1.0, -1, 0, 0.0
    if length <= FEASIBILITY * level.size:
        return share, stop, side
    for row in range(level.end):
        if (signs[ROLE, row] != HARD and signs[ROLE, row] != OWN) or signs[SIDE, row] != 0:
            continue
        norm = of_rows[NORM, row]
        rate = dot(A, row, columns, STEP, 0, n)
        if abs(rate) <= RANK_TOLERANCE * norm * length:
            continue
        bound = p.upper[row] if rate > 0.0 else p.lower[row]
        rest = bound - of_rows[VALUE, row]
        near = abs(rest) <= FEASIBILITY * norm * level.size
        reached = 0.0 if near else max(rest / rate, 0.0)
        slope = abs(rate) / norm
        if reached < share or (reached == share and not lowest and slope > steepest):
            share, stop, steepest = reached, row, slope
            side = 1 if rate > 0.0 else -1
    return share, stop, side


@compiled
def let_go(p: Problem, b: Buffers, level: Level, working: Working, lowest: bool) -> bool:
    """Take rows that hold on the wrong side out of the working rows; tell whether there were any.

    All satisfied own rows at once, or else the hard row that is most wrong; when `lowest`, only
    the row with the lowest number.
    """
    signs, columns = b.signs, b.of_columns
    wrong, worst = -1, 0.0
    if not working.met:
        for j in range(working.hard):
            row = b.numbers[ORDER, j]
            push = -columns[MULTIPLIER, j] * signs[SIDE, row]
            better = row < wrong if lowest else push > worst
            if push > columns[NOISE, j] and (wrong < 0 or better):
                wrong, worst = row, push
    if lowest and wrong >= 0:
        signs[SIDE, wrong] = 0
        return True
    if level.weight == 0.0 and release_soft(p, b, level, working, lowest):
        return True
    if wrong >= 0:
        signs[SIDE, wrong] = 0
    return wrong >= 0


@inlined
def release_soft(p: Problem, b: Buffers, level: Level, working: Working, lowest: bool) -> bool:
    """Take satisfied own rows out of the working rows; tell whether there were any."""
    signs, of_rows = b.signs, b.of_rows
    first = -1
    for i in range(working.hard, working.last):
        row = b.numbers[ORDER, i]
        margin = ZERO_TOLERANCE * of_rows[NORM, row] * level.size
        if signs[SIDE, row] == EQUALITY or of_rows[VIOLATION, i] * signs[SIDE, row] >= -margin:
            continue
        if first < 0 or row < first:
            first = row
        if not lowest:
            signs[SIDE, row] = side_of(p, row, of_rows[VALUE, row], 0.0)
    if lowest and first >= 0:
        signs[SIDE, first] = side_of(p, first, of_rows[VALUE, first], 0.0)
    return first >= 0
