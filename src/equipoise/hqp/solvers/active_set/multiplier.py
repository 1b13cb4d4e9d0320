"""Compiled multipliers of the hard working rows: who pushes how hard, and how sure that is."""

from __future__ import annotations

import numpy as np

from equipoise.compiled.compilation import compiled, inlined
from equipoise.hqp.solvers.active_set.primitives import (
    DEPENDENT_ROW,
    MULTIPLIER,
    NOISE,
    NORM,
    ORDER,
    ROUNDING,
    SCRATCH,
    SHARE,
    SOFT_MULTIPLIER,
    STEP,
    VIOLATION,
    Buffers,
    Level,
)

FAR_FROM_ROUNDING = 1e6


@compiled
def share_out(b: Buffers, fixed: int, rank: int, place: int) -> None:
    """Note a dependent row and its shares in the hard working rows, whose sum it is."""
    factor, columns = b.factor, b.of_columns
    for i in range(rank - 1, -1, -1):
        share = factor[place, fixed + i]
        for k in range(i + 1, rank):
            share -= factor[k, fixed + i] * columns[SHARE, k]
        columns[SHARE, i] = share / factor[i, fixed + i]
    b.numbers[DEPENDENT_ROW, 0] = b.numbers[ORDER, place]


@inlined
def weigh_by_violation(b: Buffers, level: Level, hard: int, last: int) -> None:
    """Fill the multipliers of the hard working rows, and their noise, from the soft rows."""
    factor, of_rows, columns = b.factor, b.of_rows, b.of_columns
    columns[MULTIPLIER, :hard] = 0.0
    rounding = 0.0
    for i in range(hard, last):
        norm, beyond = of_rows[NORM, b.numbers[ORDER, i]], of_rows[VIOLATION, i]
        rounding += ROUNDING * norm * (norm * level.size + abs(beyond))
        for j in range(hard):
            columns[MULTIPLIER, j] -= beyond * factor[i, level.fixed + j]
    weigh(b, level.fixed, hard, rounding)


@inlined
def weigh_by_goal(b: Buffers, level: Level, hard: int) -> None:
    """Fill the multipliers of the hard working rows, and their noise, from the missed goal."""
    columns = b.of_columns
    for j in range(hard):
        columns[MULTIPLIER, j] = -level.weight * columns[SCRATCH, j]
    weigh(b, level.fixed, hard, ROUNDING * level.weight * level.size)


@inlined
def weigh_by_step(b: Buffers, level: Level, hard: int, rank: int) -> None:
    """Fill the multipliers that the working rows carry where they are met, for the least step."""
    factor, columns = b.factor, b.of_columns
    top = level.fixed + hard
    for j in range(hard):
        columns[MULTIPLIER, j] = -columns[STEP, level.fixed + j]
    for i in range(rank - 1, -1, -1):
        push = -columns[STEP, top + i]
        for k in range(i + 1, rank):
            push -= factor[hard + k, top + i] * columns[SOFT_MULTIPLIER, k]
        columns[SOFT_MULTIPLIER, i] = push / factor[hard + i, top + i]
        for j in range(hard):
            columns[MULTIPLIER, j] -= (
                factor[hard + i, level.fixed + j] * columns[SOFT_MULTIPLIER, i]
            )
    weigh(b, level.fixed, hard, ROUNDING * level.size)


@compiled
def weigh(b: Buffers, fixed: int, hard: int, rounding: float) -> None:
    """Solve triangle^T x = multipliers in place; scale the rounding by the inverse's columns.

    Where a multiplier is far from rounding, the size of that is only estimated.
    """
    factor, columns = b.factor, b.of_columns
    least = np.inf
    for i in range(hard - 1, -1, -1):
        least = min(least, abs(factor[i, fixed + i]))
        columns[MULTIPLIER, i] /= factor[i, fixed + i]
        for j in range(i):
            columns[MULTIPLIER, j] -= factor[i, fixed + j] * columns[MULTIPLIER, i]
    for j in range(hard):
        columns[NOISE, j] = rounding / least
        if abs(columns[MULTIPLIER, j]) < FAR_FROM_ROUNDING * columns[NOISE, j]:
            columns[NOISE, j] = rounding * inverse_column(b, fixed, hard, j)


@inlined
def inverse_column(b: Buffers, fixed: int, hard: int, j: int) -> float:
    """Return the norm of a column of the inverse of the triangle of hard working rows."""
    factor, columns = b.factor, b.of_columns
    squares = 0.0
    for i in range(j, hard):
        rest = 1.0 if i == j else 0.0
        for k in range(j, i):
            rest -= factor[i, fixed + k] * columns[SCRATCH, k]
        columns[SCRATCH, i] = rest / factor[i, fixed + i]
        squares += columns[SCRATCH, i] ** 2
    return np.sqrt(squares)
