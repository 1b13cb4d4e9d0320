"""Compiled values of rows: A v, lengths, sides, and rows in the coordinates of a basis."""

from __future__ import annotations

import numpy as np

from equipoise.compiled.compilation import compiled, inlined
from equipoise.compiled.workspace import Block, integers, matrix, vector
from equipoise.hqp.solvers.active_set.memory import (
    A_ROWS,
    BASIS_NUMBER,
    DEPENDENT,
    EQUALITY,
    FIRST,
    FRESH,
    HARD,
    LAST,
    LOWER,
    NORM,
    NUMBERS,
    OWN,
    REDUCED,
    ROLE,
    SINGLE,
    UPPER,
)
from equipoise.hqp.solvers.active_set.primitives import column


@inlined
def value_of(rows: Block, row: int, point: np.ndarray) -> float:
    """Return a row of A times a point [n]."""
    A, single = matrix(rows, A_ROWS), integers(rows, SINGLE)
    place, total = single[row], 0.0
    if place >= 0:
        return A[row, place] * point[place]
    first, last = integers(rows, FIRST), integers(rows, LAST)
    for c in range(column(first[row]), column(last[row])):
        total += A[row, c] * point[c]
    return total


@inlined
def norm_of(rows: Block, row: int) -> float:
    """Return the length of a row of A."""
    A, single = matrix(rows, A_ROWS), integers(rows, SINGLE)
    place, total = single[row], 0.0
    if place >= 0:
        return abs(A[row, place])
    first, last = integers(rows, FIRST), integers(rows, LAST)
    for c in range(column(first[row]), column(last[row])):
        total += A[row, c] * A[row, c]
    return np.sqrt(total)


@compiled
def measure(rows: Block, search: Block, point: int, values: int, start: int, end: int) -> None:
    """Fill an array of values with A times a point for the hard and own rows start..end."""
    A, single = matrix(rows, A_ROWS), integers(rows, SINGLE)
    first, last = integers(rows, FIRST), integers(rows, LAST)
    role, x, out = integers(search, ROLE), vector(search, point), vector(search, values)
    for row in range(start, end):
        if role[row] != HARD and role[row] != OWN:
            continue
        place = single[row]
        if place >= 0:
            out[row] = A[row, place] * x[place]
        else:
            total = 0.0
            for c in range(column(first[row]), column(last[row])):
                total += A[row, c] * x[c]
            out[row] = total


@inlined
def side_of(low: float, high: float, value: float, margin: float) -> int:
    """Return the side on which a value is not within its bounds by more than a margin, or 0.

    A value or bound that is not a number counts as beyond.
    """
    if not value <= high + margin:
        return 1
    return 0 if value >= low - margin else -1


@inlined
def bound_of(rows: Block, row: int, side: int) -> float:
    """Return the bound of a row on a side."""
    return vector(rows, UPPER)[row] if side > 0 else vector(rows, LOWER)[row]


@inlined
def usable_side(rows: Block, row: int, side: int) -> int:
    """Return a remembered side of a row, 0 where it has no bound there any more."""
    low, high = vector(rows, LOWER)[row], vector(rows, UPPER)[row]
    if low == high:
        return EQUALITY if side != 0 else 0
    if side == 1 and high < np.inf:
        return 1
    return -1 if side == -1 and low > -np.inf else 0


@compiled
def reduce_row(rows: Block, search: Block, basis: int, row: int, free: int) -> None:
    """Bring a row into the coordinates of a basis of `free` directions, once for each basis.

    Where next to nothing is left of it there, it becomes zero.
    """
    number = integers(search, NUMBERS)[BASIS_NUMBER]
    fresh = integers(search, FRESH)
    if fresh[row] == number:
        return
    fresh[row] = number
    A, single = matrix(rows, A_ROWS), integers(rows, SINGLE)
    reduced, Z = matrix(search, REDUCED), matrix(search, basis)
    place, remains, squares = single[row], 0.0, 0.0
    if place >= 0:
        scale = A[row, place]
        for k in range(free):
            reduced[row, k] = scale * Z[k, place]
            remains += reduced[row, k] ** 2
        squares = scale * scale
    else:
        start, stop = column(integers(rows, FIRST)[row]), column(integers(rows, LAST)[row])
        for k in range(free):
            total = 0.0
            for c in range(start, stop):
                total += A[row, c] * Z[k, c]
            reduced[row, k] = total
            remains += total * total
        for c in range(start, stop):
            squares += A[row, c] * A[row, c]
    vector(search, NORM)[row] = np.sqrt(squares)
    if not remains > DEPENDENT**2 * squares:
        for k in range(free):
            reduced[row, k] = 0.0


@compiled
def is_dependent(rows: Block, search: Block, basis: int, row: int, free: int) -> bool:
    """Tell whether next to nothing is left of a row in the coordinates of a basis."""
    reduce_row(rows, search, basis, row, free)
    reduced = matrix(search, REDUCED)
    dependent = True
    for k in range(free):
        dependent = dependent and reduced[row, k] == 0.0
    return dependent
