"""Compiled loop over the levels: what each one starts from and what its optimum fixes."""

from __future__ import annotations

import numpy as np

from equipoise.compiled.compilation import compiled, entrance, inlined
from equipoise.hqp.solution import ACTIVE_TOLERANCE
from equipoise.hqp.solvers.active_set.primitives import (
    DEPTH,
    EQUALITY,
    FIXED,
    FREE,
    GOAL,
    HARD,
    MULTIPLIER,
    NEXT_V,
    NEXT_VALUE,
    NOISE,
    NORM,
    ORDER,
    OWN,
    ROLE,
    SCRATCH,
    SIDE,
    SINGLE,
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
from equipoise.hqp.solvers.active_set.search import guess, measure, search, side_of, value_of
from equipoise.hqp.solvers.active_set.working import eliminate, take_rows


@entrance
def answer(
    A: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    ends: np.ndarray,
    reflectors: np.ndarray,
    basis: np.ndarray,
    projected: np.ndarray,
    factor: np.ndarray,
    triangle: np.ndarray,
    memory: np.ndarray,
    numbers: np.ndarray,
    signs: np.ndarray,
    of_rows: np.ndarray,
    of_columns: np.ndarray,
    limit: int,
    v: np.ndarray,
    w: np.ndarray,
    slack: np.ndarray,
    active: np.ndarray,
) -> tuple[int, bool, bool]:
    """Solve all levels and fill v [n], w [m], the slack of the levels and the active rows [m].

    `Problem` and `Buffers` come in pieces, since a tuple costs as much as the call itself.
    Returns the number of working problems solved, whether every search ended by itself, and
    whether all numbers are finite.
    """
    p = Problem(A, lower, upper)
    b = Buffers(
        reflectors, basis, projected, factor, triangle, memory, numbers, signs, of_rows, of_columns
    )
    work, ended = solve_levels(p, ends, b, limit)
    judge(p, ends, b, v, w, slack, active)
    total = 0.0
    for c in range(v.shape[0]):
        total += v[c]
    for level in range(slack.shape[0]):
        total += slack[level]
    return work, ended, abs(total) < np.inf


@inlined
def solve_levels(p: Problem, ends: np.ndarray, b: Buffers, limit: int) -> tuple[int, bool]:
    """Solve all levels and then the least norm, leaving v in the buffers."""
    columns = b.of_columns
    n = columns.shape[1]
    velocity = prepare(p, b)
    fixed, start, total, ended = 0, 0, 0, True
    for number in range(ends.size + 1):
        least_norm = number == ends.size
        end = start if least_norm else ends[number]
        if fixed == n:
            break
        if start == end and not least_norm:
            continue
        weight = 1.0
        if least_norm:
            columns[GOAL, :] = 0.0
        else:
            weight = goal_weight(p, b, start, end)
        size = max(velocity, np.sqrt(dot(columns, V, columns, V, 0, n)))
        level = Level(fixed, start, end, number, weight, size)
        fixed, work, done = solve_level(p, b, level, limit)
        total += work
        ended = ended and done
        start = end
    return total, ended


@compiled
def prepare(p: Problem, b: Buffers) -> float:
    """Clear the buffers; return the size of v that the bounds ask for at least."""
    A, projected, of_rows = p.A, b.projected, b.of_rows
    m, n = A.shape
    velocity = 0.0
    b.of_columns[V, :] = 0.0
    b.signs[:, :] = 0
    b.numbers[DEPTH, :] = 0
    for row in range(m):
        if p.lower[row] == -np.inf and p.upper[row] == np.inf:
            b.signs[ROLE, row] = FREE
            continue
        copy_row(projected, row, A, row)
        place = only_column(A, row)
        norm = abs(A[row, place]) if place >= 0 else np.sqrt(dot(A, row, A, row, 0, n))
        b.numbers[SINGLE, row], of_rows[NORM, row] = place, norm
        beyond = max(p.lower[row], 0.0) + max(-p.upper[row], 0.0)
        if beyond > velocity * norm and norm > 0.0:
            velocity = beyond / norm
    return velocity


@inlined
def only_column(A: np.ndarray, row: int) -> int:
    """Return the only column in which a row is not zero, -1 if there is not exactly one."""
    place = -1
    for c in range(A.shape[1]):
        if A[row, c] != 0.0:
            if place >= 0:
                return -1
            place = c
    return place


@compiled
def goal_weight(p: Problem, b: Buffers, start: int, end: int) -> float:
    """Return c^2 where a level is c v = c goal for every unknown, else 0; fill the goal."""
    A, columns = p.A, b.of_columns
    n = A.shape[1]
    if end - start != n:
        return 0.0
    columns[SCRATCH, :] = 0.0
    weight = 0.0
    for row in range(start, end):
        place = b.numbers[SINGLE, row]
        if p.lower[row] != p.upper[row] or place < 0 or columns[SCRATCH, place] != 0.0:
            return 0.0
        square = A[row, place] ** 2
        if row > start and square != weight:
            return 0.0
        weight = square
        columns[SCRATCH, place] = 1.0
        columns[GOAL, place] = p.lower[row] / A[row, place]
    return weight


@compiled
def solve_level(p: Problem, b: Buffers, level: Level, limit: int) -> tuple[int, int, bool]:
    """Find the optimum of a level; return the reflectors fixed then, the work, how it ended."""
    for row in range(level.start, level.end):
        if b.signs[ROLE, row] != FREE:
            b.signs[ROLE, row] = OWN
    measure(p, b, V, VALUE, level.start, level.end)
    remember(p, b, level)
    working, work, ended = guess(p, b, level)
    if ended:
        for row in range(level.end):
            b.of_rows[VALUE, row] = b.of_rows[NEXT_VALUE, row]
    else:
        working, more, ended = search(p, b, level, limit)
        work += more
    copy_row(b.of_columns, V, b.of_columns, NEXT_V)
    for row in range(level.end):
        b.memory[level.number, row] = b.signs[SIDE, row]
    if level.weight > 0.0 and ended:
        return b.of_columns.shape[1], work, ended
    return settle(p, b, level, working, ended), work, ended


@compiled
def remember(p: Problem, b: Buffers, level: Level) -> None:
    """Start from the working rows of the last answer, where they still make sense."""
    signs = b.signs
    for row in range(level.end):
        if signs[ROLE, row] == FREE:
            continue
        side = b.memory[level.number, row]
        exists = (side == 1 and p.upper[row] < np.inf) or (side == -1 and p.lower[row] > -np.inf)
        if row < level.start:
            signs[SIDE, row] = side if exists and signs[ROLE, row] == HARD else 0
        elif p.lower[row] == p.upper[row]:
            signs[SIDE, row] = EQUALITY
        else:
            signs[SIDE, row] = side if exists else side_of(p, row, b.of_rows[VALUE, row], 0.0)


@compiled
def settle(p: Problem, b: Buffers, level: Level, working: Working, ended: bool) -> int:
    """Fix what the optimum fixes and keep the other rows as hard ones; return the reflectors."""
    signs, order, of_rows, columns = b.signs, b.numbers, b.of_rows, b.of_columns
    loose, broken = False, False
    for j in range(working.hard):
        weighs = abs(columns[MULTIPLIER, j]) > columns[NOISE, j]
        if ended and not working.met and weighs:
            signs[ROLE, order[ORDER, j]] = FIXED
        else:
            loose = True
    hard_loose = loose
    for i in range(working.hard, working.last):
        row = order[ORDER, i]
        margin = ZERO_TOLERANCE * of_rows[NORM, row] * level.size
        violated = not working.met and abs(of_rows[VIOLATION, i]) > margin
        if signs[SIDE, row] == EQUALITY:
            signs[ROLE, row] = FIXED
        elif violated:
            signs[ROLE, row] = FIXED
            broken = True
        else:
            loose = True
    for row in range(level.start, level.end):
        if signs[ROLE, row] == OWN:
            signs[ROLE, row] = HARD
    if not loose:
        return level.fixed + working.hard + working.rank
    if not (hard_loose or broken):  # only equalities stay, and they were eliminated first
        return level.fixed + working.hard + working.equal_rank
    return fix_again(p, b, level.fixed, working.last)


@inlined
def fix_again(p: Problem, b: Buffers, fixed: int, last: int) -> int:
    """Eliminate only the fixed ones among the working rows; return the reflectors."""
    order, count = b.numbers, 0
    for i in range(last):
        row = order[ORDER, i]
        if b.signs[ROLE, row] == FIXED:
            order[ORDER, count] = row
            count += 1
    take_rows(p, b, 0, count, fixed, 0)
    return fixed + eliminate(b, fixed, 0, count, count)


@compiled
def judge(
    p: Problem,
    ends: np.ndarray,
    b: Buffers,
    v: np.ndarray,
    w: np.ndarray,
    slack: np.ndarray,
    active: np.ndarray,
) -> None:
    """Copy v out and fill w, the slack of the levels and the active rows at it.

    The values of hard rows at it are known from the last level.
    """
    columns, start = b.of_columns, 0
    for c in range(v.shape[0]):
        v[c] = columns[V, c]
    for level in range(ends.size):
        squares = 0.0
        for row in range(start, ends[level]):
            role = b.signs[ROLE, row]
            if role == FREE:
                w[row], active[row] = 0.0, 0
                continue
            value = b.of_rows[VALUE, row] if role == HARD else value_of(p, b, row, V)
            low, high = p.lower[row], p.upper[row]
            w[row] = value - min(max(value, low), high)
            squares += w[row] ** 2
            near = ACTIVE_TOLERANCE * (1.0 + abs(value))
            active[row] = int(value >= high - near) - int(value <= low + near)
            if low == high:
                active[row] = EQUALITY
        slack[level] = np.sqrt(squares)
        start = ends[level]
