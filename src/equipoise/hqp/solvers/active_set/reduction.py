"""Compiled reduction: equalities that must hold leave the unknowns, a smaller basis is left.

`point` is where we stand and `basis` spans, by its first FREE rows, where we may still go. At first
the basis is the unit matrix, which is not written down: `NUMBERS[FREE]` is then -1.
"""

from __future__ import annotations

import numpy as np

from equipoise.compiled.compilation import compiled, inlined
from equipoise.compiled.workspace import Block, integers, matrix, vector
from equipoise.hqp.solvers.active_set.elimination import (
    eliminate_in_order,
    eliminate_largest,
    reach_in_turn,
    span_rest,
)
from equipoise.hqp.solvers.active_set.memory import (
    A_ROWS,
    ALONG,
    BASIS,
    BASIS_NUMBER,
    BEGIN,
    COUNTS,
    FACTOR,
    FINISH,
    FIRST,
    FIXED,
    FREE,
    HARD,
    INDEPENDENT,
    LAST,
    LOWER,
    NORM,
    NUMBERS,
    ORDER,
    OUT,
    PLACE,
    POINT,
    REDUCED,
    RELEARN,
    REST,
    ROLE,
    SQUARE,
    TURNED,
    UPPER,
    WHITE,
)
from equipoise.hqp.solvers.active_set.primitives import column, copy_row
from equipoise.hqp.solvers.active_set.values import norm_of, reduce_row, value_of


@inlined
def is_equality(rows: Block, search: Block, row: int) -> bool:
    """Tell whether a row counts and is an equality."""
    low, high = vector(rows, LOWER), vector(rows, UPPER)
    return integers(search, COUNTS)[row] != 0 and low[row] == high[row]


@compiled
def write_unit_basis(search: Block, n: int) -> None:
    """Write the unit matrix down as the basis, if it was not written yet."""
    numbers, Z = integers(search, NUMBERS), matrix(search, BASIS)
    if numbers[FREE] >= 0:
        return
    for k in range(n):
        for c in range(column(n)):
            Z[k, c] = 0.0
        Z[k, k] = 1.0
    numbers[FREE] = n
    numbers[BASIS_NUMBER] += 1


@compiled
def merge(rows: Block, search: Block, begin: int, end: int) -> None:
    """Take the rows begin..end, levels that are to be met, as hard; reduce by their equalities."""
    role = integers(search, ROLE)
    for row in range(begin, end):
        if role[row] != OUT:
            role[row] = HARD
    count = take_remembered(rows, search, begin, end)
    n = matrix(rows, A_ROWS).shape[1]
    if count > 0 and eliminate_in_order(search, count, dimension(search, n)):
        go_on(rows, search, count, n)
        return
    count = take_all(rows, search, begin, end)
    if count == 0:
        return
    rank = eliminate_largest(search, 0, 0, count, count, dimension(search, n), True)
    learn(rows, search, begin, end, 0, rank)
    go_on(rows, search, rank, n)


@inlined
def dimension(search: Block, n: int) -> int:
    """Return the number of directions that are free, n at first."""
    free = integers(search, NUMBERS)[FREE]
    return n if free < 0 else free


@inlined
def take_remembered(rows: Block, search: Block, begin: int, end: int) -> int:
    """Load the remembered independent equalities among the rows begin..end; return their number."""
    order, place = integers(search, ORDER), integers(search, PLACE)
    count = 0
    for k in range(order.shape[0]):
        row = order[k]
        if row < 0:
            break
        if begin <= row < end and is_equality(rows, search, row):
            place[count] = row
            load(rows, search, count)
            count += 1
    return count


@inlined
def take_all(rows: Block, search: Block, begin: int, end: int) -> int:
    """Load all equalities among the rows begin..end; return their number."""
    place, count = integers(search, PLACE), 0
    for row in range(begin, end):
        if is_equality(rows, search, row):
            place[count] = row
            load(rows, search, count)
            count += 1
    return count


@compiled
def load(rows: Block, search: Block, i: int) -> None:
    """Write the equality at a working place into the factor, with its support and its rest."""
    A, factor, reduced = matrix(rows, A_ROWS), matrix(search, FACTOR), matrix(search, REDUCED)
    begin, finish = integers(search, BEGIN), integers(search, FINISH)
    row, free = integers(search, PLACE)[i], integers(search, NUMBERS)[FREE]
    if free < 0:
        copy_row(factor, i, A, row, A.shape[1])
        begin[i], finish[i] = integers(rows, FIRST)[row], integers(rows, LAST)[row]
        vector(search, NORM)[row] = norm_of(rows, row)
    else:
        reduce_row(rows, search, BASIS, row, free)
        copy_row(factor, i, reduced, row, free)
        begin[i], finish[i] = 0, free
    reached = value_of(rows, row, vector(search, POINT))
    vector(search, REST)[i] = vector(rows, LOWER)[row] - reached


@compiled
def learn(rows: Block, search: Block, begin: int, end: int, first: int, last: int) -> None:
    """Note which equalities among the rows begin..end were eliminated, at places first..last."""
    independent, place = integers(search, INDEPENDENT), integers(search, PLACE)
    low, high = vector(rows, LOWER), vector(rows, UPPER)
    for row in range(begin, end):
        independent[row] = 0
    for i in range(first, last):
        row = place[i]
        if begin <= row < end and low[row] == high[row]:
            independent[row] = 1
    integers(search, NUMBERS)[RELEARN] = 1


@compiled
def go_on(rows: Block, search: Block, rank: int, n: int) -> None:
    """Go to where the eliminated equalities hold, and take a basis of what they leave free."""
    numbers, role, place = (
        integers(search, NUMBERS),
        integers(search, ROLE),
        integers(search, PLACE),
    )
    turned, along, point = vector(search, TURNED), vector(search, ALONG), vector(search, POINT)
    free = dimension(search, n)
    reach_in_turn(search, 0, 0, rank)
    for j in range(free):
        turned[j] = along[j] if j < rank else 0.0
    for i in range(rank):
        role[place[i]] = FIXED
    if numbers[FREE] < 0:
        span_rest(search, BASIS, rank, n)
        for c in range(n):
            point[c] += turned[c]
        numbers[FREE] = n - rank
    else:
        span_rest(search, SQUARE, rank, free)
        combine(search, point)
        shrink(search, rank, free)
    numbers[BASIS_NUMBER] += 1


@inlined
def combine(search: Block, point: np.ndarray) -> None:
    """Add the turned coordinates, times the basis, to a point."""
    Z, turned = matrix(search, BASIS), vector(search, TURNED)
    for k in range(integers(search, NUMBERS)[FREE]):
        scale = turned[k]
        for c in range(column(Z.shape[1])):
            point[c] += scale * Z[k, c]


@compiled
def shrink(search: Block, rank: int, free: int) -> None:
    """Take the combinations in `square` [free - rank, free] of the basis as the new basis."""
    Z, B, new = matrix(search, BASIS), matrix(search, SQUARE), matrix(search, WHITE)
    n = Z.shape[1]
    for i in range(free - rank):
        for c in range(column(n)):
            new[i, c] = 0.0
        for k in range(free):
            scale = B[i, k]
            for c in range(column(n)):
                new[i, c] += scale * Z[k, c]
    for i in range(free - rank):
        copy_row(Z, i, new, i, n)
    integers(search, NUMBERS)[FREE] = free - rank


@compiled
def order_independent(rows: Block, search: Block) -> None:
    """Write the independent equalities in the order of their last columns, which stay narrow."""
    independent, order = integers(search, INDEPENDENT), integers(search, ORDER)
    last, count = integers(rows, LAST), 0
    for row in range(independent.shape[0]):
        if independent[row] == 0:
            continue
        i = count
        while i > 0 and last[order[i - 1]] > last[row]:
            order[i] = order[i - 1]
            i -= 1
        order[i] = row
        count += 1
    for i in range(count, order.shape[0]):
        order[i] = -1
