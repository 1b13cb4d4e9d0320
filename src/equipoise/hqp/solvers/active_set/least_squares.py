"""Compiled least squares of soft working rows that cannot all be met.

The rows were eliminated, the largest first: L1 the triangle of the independent ones, L2 the others,
in coordinates y. With T = L2 L1^-1, whose entries are moderate since large rows went first, and the
violations w1 = L1 y - r1, w2 = L2 y - r2 the least |w1|^2 + |w2|^2 has w1 = -T^T w2 and

    (I + T^T T) w1 = -T^T (T r1 - r2).

All that is inverted here is at least one, whatever the lengths of the rows: a row of 1e-4 beside
one of 1e4 gets its violation as exactly, for its own length, as that. Rounding of the violations is
kept with them, since rows are judged by their signs.

Source: Peters and Wilkinson (1970), for the least-squares problem of a trapezoidal factor.
"""

from __future__ import annotations

import numpy as np

from equipoise.compiled.compilation import compiled, inlined
from equipoise.compiled.workspace import Block, integers, matrix, vector
from equipoise.hqp.solvers.active_set.memory import (
    ALONG,
    FACTOR,
    INVERSE,
    MET_TOLERANCE,
    MISS,
    MIX,
    NORM,
    PLACE,
    REST,
    ROUNDING,
    SHAKE,
    SHARE,
    SQUARE,
    TURNED,
)
from equipoise.hqp.solvers.active_set.primitives import (
    column,
    dot_vector,
    factorise,
    length,
    solve_factorised,
)


@compiled
def solve_soft(search: Block, top: int, last: int, rank: int, size: float) -> tuple[bool, float]:
    """Solve the soft rows at places top..last for coordinates from `top` on.

    Fills the violations by place, and their rounding. Returns whether all are met, and the size of
    v, at first the one given, that this was judged with.
    """
    miss, shake, rest = vector(search, MISS), vector(search, SHAKE), vector(search, REST)
    norm, place, along = vector(search, NORM), integers(search, PLACE), vector(search, ALONG)
    factor = matrix(search, FACTOR)
    for i in range(top, last):
        miss[i], shake[i] = 0.0, 0.0
    solve_triangle(search, top, rank)
    size = max(size, length(along, top + rank))
    met = True
    for i in range(top + rank, last):
        miss[i] = dot_vector(factor, i, along, top, top + rank) - rest[i]
        met = met and abs(miss[i]) <= MET_TOLERANCE * norm[place[i]] * size
    if met:
        for i in range(top + rank, last):
            miss[i] = 0.0
        return True, size
    invert_triangle(search, top, rank)
    mix_dependent(search, top, last, rank)
    compromise(search, top, last, rank)
    weigh_rounding(search, top, last, rank, size)
    solve_triangle(search, top, rank)
    return False, size


@inlined
def solve_triangle(search: Block, top: int, rank: int) -> None:
    """Solve the independent soft rows, with their violations, for coordinates from `top` on."""
    miss, rest, along = vector(search, MISS), vector(search, REST), vector(search, ALONG)
    factor = matrix(search, FACTOR)
    for i in range(top, top + rank):
        along[i] = (rest[i] + miss[i] - dot_vector(factor, i, along, top, i)) / factor[i, i]


@inlined
def invert_triangle(search: Block, first: int, rank: int) -> None:
    """Write the inverse of the triangle of independent rows, and the norms of its columns."""
    factor, inverse = matrix(search, FACTOR), matrix(search, INVERSE)
    lengths = vector(search, TURNED)
    for k in range(rank):
        lengths[k] = 0.0
    for i in range(rank):
        scale = 1.0 / factor[first + i, first + i]
        for k in range(column(i)):
            inverse[i, k] = 0.0
        inverse[i, i] = 1.0
        for l in range(i):
            share = factor[first + i, first + l]
            for k in range(column(l + 1)):
                inverse[i, k] -= share * inverse[l, k]
        for k in range(column(i + 1)):
            inverse[i, k] *= scale
            lengths[k] += inverse[i, k] * inverse[i, k]
    for k in range(rank):
        lengths[k] = np.sqrt(lengths[k])


@inlined
def mix_dependent(search: Block, first: int, last: int, rank: int) -> None:
    """Write the dependent rows as sums of the independent ones, T = L2 L1^-1."""
    factor, mix, inverse = matrix(search, FACTOR), matrix(search, MIX), matrix(search, INVERSE)
    for i in range(first + rank, last):
        for k in range(column(rank)):
            mix[i, k] = 0.0
        for l in range(rank):
            share = factor[i, first + l]
            for k in range(column(l + 1)):
                mix[i, k] += share * inverse[l, k]


@inlined
def compromise(search: Block, first: int, last: int, rank: int) -> None:
    """Turn what the dependent rows would miss into the violations of least squares."""
    miss, mix, square = vector(search, MISS), matrix(search, MIX), matrix(search, SQUARE)
    own = vector(search, SHARE)
    for k in range(rank):
        own[k] = 0.0
        for l in range(k + 1):
            square[k, l] = 0.0
        square[k, k] = 1.0
    for i in range(first + rank, last):
        for k in range(rank):
            scale = mix[i, k]
            own[k] -= scale * miss[i]
            for l in range(column(k + 1)):
                square[k, l] += scale * mix[i, l]
    if not factorise(square, rank, 0.0):
        miss[first] = np.nan
        return
    solve_factorised(square, own, rank)
    for i in range(first + rank, last):
        miss[i] += dot_vector(mix, i, own, 0, rank)
    for k in range(rank):
        miss[first + k] = 0.0
    for i in range(first + rank, last):
        for k in range(rank):
            miss[first + k] -= mix[i, k] * miss[i]


@inlined
def weigh_rounding(search: Block, first: int, last: int, rank: int, size: float) -> None:
    """Fill the rounding of the violations.

    That of a row is its length times the size of v; of the sums T, the length of the dependent row
    times the inverse of the triangle.
    """
    miss, shake, mix = vector(search, MISS), vector(search, SHAKE), matrix(search, MIX)
    norm, place, lengths = vector(search, NORM), integers(search, PLACE), vector(search, TURNED)
    pulled = 0.0
    for i in range(first + rank, last):
        pulled += ROUNDING * norm[place[i]] * abs(miss[i])
    for k in range(rank):
        shake[first + k] = pulled * lengths[k]
    for i in range(first + rank, last):
        shake[i] = ROUNDING * (norm[place[i]] * size + abs(miss[i]))
        for k in range(rank):
            of_row = ROUNDING * norm[place[first + k]] * size + pulled * lengths[k]
            shake[i] += abs(mix[i, k]) * of_row
    for i in range(first + rank, last):
        for k in range(rank):
            shake[first + k] += abs(mix[i, k]) * shake[i]
