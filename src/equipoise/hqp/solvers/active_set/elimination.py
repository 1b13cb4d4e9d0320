"""Compiled elimination of working rows by reflectors, and the basis of what they leave free."""

from __future__ import annotations

import numpy as np

from equipoise.compiled.compilation import compiled, inlined
from equipoise.compiled.workspace import Block, integers, matrix, vector
from equipoise.hqp.solvers.active_set.memory import (
    ALONG,
    BEGIN,
    DEPENDENT,
    FACTOR,
    FINISH,
    LEFT,
    NORM,
    ONCE_LEFT,
    PLACE,
    REACH,
    REFLECTORS,
    REST,
    SAFE_PIVOT,
    TURNED,
)
from equipoise.hqp.solvers.active_set.primitives import (
    column,
    dot,
    dot_vector,
    make_reflector,
    reflect,
    reflect_vector,
)

SUM_UP_AGAIN = 1e-3


@compiled
def eliminate_in_order(search: Block, count: int, n: int) -> bool:
    """Eliminate the rows at places 0..count in turn, within their supports.

    Returns False, and leaves everything half done, where too little is left of a row.
    """
    factor, u = matrix(search, FACTOR), matrix(search, REFLECTORS)
    begin, finish = integers(search, BEGIN), integers(search, FINISH)
    norm, place, reach = vector(search, NORM), integers(search, PLACE), integers(search, REACH)
    if count > n:
        return False
    for j in range(count):
        stop = min(n, (finish[j] + 3) // 4 * 4)
        squares = dot(factor, j, factor, j, j, stop) if stop > j else 0.0
        if not squares > (SAFE_PIVOT * norm[place[j]]) ** 2:
            return False
        make_reflector(factor, j, u, j, stop, np.sqrt(squares))
        reach[j] = stop
        for i in range(j + 1, count):
            if begin[i] < stop and finish[i] > j:
                reflect(factor, i, u, j, stop)
                begin[i] = min(begin[i], j)
                finish[i] = max(finish[i], stop)
    return True


@compiled
def sum_up(search: Block, first: int, last: int, start: int, stop: int, relative: bool) -> None:
    """Fill the square of what is left of the rows at places first..last, of their own if asked."""
    factor, left, once = matrix(search, FACTOR), vector(search, LEFT), vector(search, ONCE_LEFT)
    norm, place = vector(search, NORM), integers(search, PLACE)
    for i in range(first, last):
        left[i] = dot(factor, i, factor, i, start, stop)
        if relative and norm[place[i]] > 0.0:
            left[i] /= norm[place[i]] ** 2
        once[i] = left[i]


@compiled
def eliminate_largest(
    search: Block, top: int, first: int, until: int, last: int, stop: int, relative: bool
) -> int:
    """Eliminate rows first..until from column `top` on, the largest first; return the rank.

    `relative`: the largest in comparison with its length. The rows up to `last` are reflected with
    them. Only when all rows that are left are dependent, what is left of them becomes zero: one of
    them may have as much to say as the last pivot.
    """
    factor, u = matrix(search, FACTOR), matrix(search, REFLECTORS)
    left, once, norm = vector(search, LEFT), vector(search, ONCE_LEFT), vector(search, NORM)
    place, reach = integers(search, PLACE), integers(search, REACH)
    sum_up(search, first, last, top, stop, relative)
    rank = 0
    while first + rank < until and top + rank < stop:
        here, j = first + rank, top + rank
        best, most = -1, 0.0
        for i in range(here, until):
            if left[i] > most:
                best, most = i, left[i]
        if best < 0:
            break
        own = norm[place[best]]
        remains = np.sqrt(dot(factor, best, factor, best, j, stop))
        if not remains > DEPENDENT * own:
            left[best] = 0.0
            continue
        swap_places(search, here, best, stop)
        make_reflector(factor, here, u, j, stop, remains)
        reach[j] = stop
        for i in range(here + 1, last):
            reflect(factor, i, u, j, stop)
        for i in range(here + 1, last):
            if left[i] > 0.0:
                scale = norm[place[i]] ** 2 if relative else 1.0
                left[i] -= factor[i, j] ** 2 / scale
                if left[i] <= SUM_UP_AGAIN * once[i]:
                    left[i] = dot(factor, i, factor, i, j + 1, stop) / scale
                    once[i] = left[i]
        rank += 1
    for i in range(first + rank, until):
        for c in range(top + rank, stop):
            factor[i, c] = 0.0
    return rank


@inlined
def swap_places(search: Block, i: int, k: int, stop: int) -> None:
    """Swap two working rows."""
    if i == k:
        return
    factor, place = matrix(search, FACTOR), integers(search, PLACE)
    rest, left, once = vector(search, REST), vector(search, LEFT), vector(search, ONCE_LEFT)
    for c in range(column(stop)):
        factor[i, c], factor[k, c] = factor[k, c], factor[i, c]
    place[i], place[k] = place[k], place[i]
    rest[i], rest[k] = rest[k], rest[i]
    left[i], left[k] = left[k], left[i]
    once[i], once[k] = once[k], once[i]


@inlined
def reach_in_turn(search: Block, top: int, first: int, rank: int) -> None:
    """Solve the triangle of eliminated rows first..first+rank for coordinates along reflectors."""
    factor, rest, along = matrix(search, FACTOR), vector(search, REST), vector(search, ALONG)
    for k in range(rank):
        i, j = first + k, top + k
        along[j] = (rest[i] - dot_vector(factor, i, along, 0, j)) / factor[i, j]


@compiled
def turn_back(search: Block, rank: int, size: int) -> None:
    """Turn coordinates along the reflectors, in place of `turned` [size], into those before."""
    turned, u, reach = vector(search, TURNED), matrix(search, REFLECTORS), integers(search, REACH)
    for j in range(rank - 1, -1, -1):
        reflect_vector(turned, u, j, reach[j])


@compiled
def span_rest(search: Block, basis: int, rank: int, size: int) -> None:
    """Write an orthonormal basis of what `rank` reflectors leave free, size - rank rows.

    Turns the coordinates in `turned` back with it, which hides the waiting of one row for itself.
    """
    Z, u = matrix(search, basis), matrix(search, REFLECTORS)
    turned, reach = vector(search, TURNED), integers(search, REACH)
    begin, finish = integers(search, BEGIN), integers(search, FINISH)
    free = size - rank
    for k in range(free):
        for c in range(column(size)):
            Z[k, c] = 0.0
        Z[k, rank + k] = 1.0
        begin[k], finish[k] = rank + k, rank + k + 1
    for j in range(rank - 1, -1, -1):
        stop = reach[j]
        for k in range(free):
            if begin[k] < stop and finish[k] > j:
                reflect(Z, k, u, j, stop)
                begin[k], finish[k] = min(begin[k], j), max(finish[k], stop)
        reflect_vector(turned, u, j, stop)
