"""Compiled primitives of the active-set solver: its buffers, inner products, reflectors.

Reflector j is a row u of length sqrt(2), zero before column j; it maps a row x to x - (x . u) u.
The product of reflectors 0, 1, ... is an orthonormal Q, and a row a has the coordinates a Q.

All kernels are plain Python, and run uncompiled under NUMBA_DISABLE_JIT=1. What speed asked for:
rows are addressed as (array, row number) and arrays leave their tuple before a loop, since compiled
code pays for views; inner loops run over unsigned columns; one reflector goes over many rows rather
than many over one, which would wait for itself; reflectors start at a multiple of four columns.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from equipoise.compiled.compilation import compiled, inlined

column = np.uint64

# rows of Buffers.of_rows: norm of a row, its value at v and at the next v, and for the working
# rows by place: the square of what is left of it, now and when last summed up, what it has to
# reach, its violation
NORM, VALUE, NEXT_VALUE, LEFT, ONCE_LEFT, REST, VIOLATION = range(7)
# rows of Buffers.of_columns: v, the next v, the step in either coordinates, the goal of a level of
# unit rows, scratch, and by place of the hard working rows their multipliers, the rounding of
# those, their shares in the dependent row, and by rank the multipliers of soft rows that are met
V, NEXT_V, STEP, GOAL, SCRATCH, MULTIPLIER, NOISE, SHARE, SOFT_MULTIPLIER = range(9)
# rows of Buffers.numbers: reflectors applied to a projected row, the row at a working place, at 0
# the broken hard row that depends on the working ones (-1: none), and the only column in which a
# row of A is not zero (-1: there are more)
DEPTH, ORDER, DEPENDENT_ROW, SINGLE = range(4)
# rows of Buffers.signs
ROLE, SIDE = range(2)
# values of a side: +1 upper, -1 lower, 0 not working, and
EQUALITY, DEPENDENT = 2, 3
# values of a role, beside 0 for rows of later levels; FREE rows have no bounds, nobody reads them
HARD, OWN, FIXED, FREE = 1, 2, 3, 4

RANK_TOLERANCE = 1e-10  # a row of which less than this share is left counts as dependent
ZERO_TOLERANCE = 1e-10  # a violation below this share of (row norm) (size of v) counts as none
FEASIBILITY = 1e-11  # the same, for a row that nobody wants violated
ROUNDING = 1e-14


class Problem(NamedTuple):
    """The stacked rows: `A` [m, n], `lower` [m], `upper` [m]."""

    A: np.ndarray
    lower: np.ndarray
    upper: np.ndarray


class Level(NamedTuple):
    """The level at hand: its rows start..end, its number, and the reflectors fixed before it.

    `weight` above zero: its rows are the unit matrix times the root of that, with the goal in the
    buffers. `size`: the size of v that residuals are compared with.
    """

    fixed: int
    start: int
    end: int
    number: int
    weight: float
    size: float


class Working(NamedTuple):
    """A solved working problem: `hard` rows, `last` rows in all, the `rank` of the soft ones.

    `equal_rank`: that of the equalities among these, which come first. `met`: no soft working row
    is violated.
    """

    hard: int
    last: int
    rank: int
    equal_rank: int
    met: bool


class Buffers(NamedTuple):
    """Everything that a search writes to, allocated once for m rows, n unknowns and p levels.

    `reflectors` [n, n]; `basis` [n, n], of what they leave free; `projected` [m, n], the rows of A
    after their first few reflectors; `factor` [m, n], the working rows by place, eliminated;
    `triangle` [n, m], of an overdetermined problem; `memory` [p + 1, m], the sides at the last
    answer; the others as named above.
    """

    reflectors: np.ndarray
    basis: np.ndarray
    projected: np.ndarray
    factor: np.ndarray
    triangle: np.ndarray
    memory: np.ndarray
    numbers: np.ndarray
    signs: np.ndarray
    of_rows: np.ndarray
    of_columns: np.ndarray


def allocate(m: int, n: int, levels: int) -> Buffers:
    """Return buffers for m rows, n unknowns and a number of levels."""
    return Buffers(
        reflectors=np.zeros((n, n)),
        basis=np.zeros((n, n)),
        projected=np.zeros((m, n)),
        factor=np.zeros((m, n)),
        triangle=np.zeros((n, m)),
        memory=np.zeros((levels + 1, m), dtype=np.int8),
        numbers=np.zeros((4, m), dtype=np.int64),
        signs=np.zeros((2, m), dtype=np.int8),
        of_rows=np.zeros((7, m)),
        of_columns=np.zeros((9, n)),
    )


@inlined
def dot(x: np.ndarray, i: int, y: np.ndarray, j: int, start: int, stop: int) -> float:
    """Return x[i, start:stop] . y[j, start:stop]."""
    total = 0.0
    for c in range(column(start), column(stop)):
        total += x[i, c] * y[j, c]
    return total


@inlined
def reflect(x: np.ndarray, i: int, u: np.ndarray, j: int, stop: int) -> None:
    """Apply reflector u[j, j:stop] to x[i, j:stop]; u[j, :j] is zero."""
    reflect_from(x, i, u, j, j - j % 4, stop)


@inlined
def reflect_from(x: np.ndarray, i: int, u: np.ndarray, j: int, start: int, stop: int) -> None:
    """Apply reflector u[j, start:stop] to x[i, start:stop]."""
    along = 0.0
    for c in range(column(start), column(stop)):
        along += x[i, c] * u[j, c]
    for c in range(column(start), column(stop)):
        x[i, c] -= along * u[j, c]


@compiled
def make_reflector(x: np.ndarray, i: int, u: np.ndarray, j: int, stop: int, length: float) -> float:
    """Write to u[j] the reflector that leaves of x[i, j:stop] the first entry; return that.

    `length` is the norm of x[i, j:stop].
    """
    first = x[i, j]
    kept = -length if first >= 0.0 else length
    scale = 1.0 / np.sqrt(length * (length + abs(first)))
    for c in range(column(j), column(stop)):
        u[j, c] = x[i, c] * scale
    u[j, j] = (first - kept) * scale
    return kept


@compiled
def copy_row(x: np.ndarray, i: int, y: np.ndarray, j: int) -> None:
    """Copy y[j] to x[i]."""
    for c in range(column(x.shape[1])):
        x[i, c] = y[j, c]
