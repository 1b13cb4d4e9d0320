"""Compiled factor of the held rows: hard rows at a bound, eliminated one after the other.

In the coordinates z of a basis the held rows are N z = b, and the point nearest to a goal g has
z = g - N^T x with multipliers x, of the sign of the side for an inequality. With N = L Q1^T the
part of z along the reflectors is L^-1 b, and L^T x is how far that keeps it from the goal.
"""

from __future__ import annotations

import numpy as np

from equipoise.compiled.compilation import compiled, inlined
from equipoise.compiled.workspace import Block, integer_matrix, integers, matrix, vector
from equipoise.hqp.solvers.active_set.elimination import reach_in_turn, turn_back
from equipoise.hqp.solvers.active_set.memory import (
    ALONG,
    DEPENDENT,
    EQUALITY,
    FACTOR,
    FREE,
    GOAL,
    HARD,
    HELD,
    MULTIPLIER,
    NEXT_V,
    NORM,
    NUMBERS,
    PLACE,
    POINT,
    REACH,
    REDUCED,
    REFLECTORS,
    REST,
    ROLE,
    ROUNDING,
    SHARE,
    SIDE,
    SIDES,
    TOWARD,
    TURNED,
)
from equipoise.hqp.solvers.active_set.primitives import (
    column,
    copy_row,
    copy_vector,
    dot,
    make_reflector,
    reflect,
    reflect_vector,
)
from equipoise.hqp.solvers.active_set.values import bound_of, reduce_row, usable_side, value_of


@compiled
def hold_remembered(rows: Block, search: Block, basis: int, number: int, end: int) -> None:
    """Hold the hard rows that an answer held last time, where they have a bound there."""
    sides, side = matrix_of_sides(search), integers(search, SIDE)
    role, numbers = integers(search, ROLE), integers(search, NUMBERS)
    numbers[HELD] = 0
    for row in range(end):
        if role[row] != HARD:
            continue
        side[row] = 0
        if sides[number, row] != 0:
            wanted = usable_side(rows, row, sides[number, row])
            if wanted != 0:
                hold(rows, search, basis, row, wanted)


@inlined
def matrix_of_sides(search: Block) -> np.ndarray:
    """Return the remembered sides [levels + 1, m]."""
    return integer_matrix(search, SIDES)


@compiled
def hold(rows: Block, search: Block, basis: int, row: int, side: int) -> bool:
    """Hold one more row; returns False, and does not, where it depends on the held ones."""
    numbers, reduced, factor = (
        integers(search, NUMBERS),
        matrix(search, REDUCED),
        matrix(search, FACTOR),
    )
    free, held = numbers[FREE], numbers[HELD]
    reduce_row(rows, search, basis, row, free)
    copy_row(factor, held, reduced, row, free)
    for j in range(held):
        reflect(factor, held, matrix(search, REFLECTORS), j, free)
    if not append(search, held, row, free):
        return False
    rest = bound_of(rows, row, side) - value_of(rows, row, vector(search, POINT))
    vector(search, REST)[held] = rest
    integers(search, SIDE)[row] = side
    numbers[HELD] = held + 1
    return True


@inlined
def append(search: Block, held: int, row: int, free: int) -> bool:
    """Eliminate the row at place `held`; False where too little is left of it."""
    factor, u = matrix(search, FACTOR), matrix(search, REFLECTORS)
    if held >= free:
        return False
    left = np.sqrt(dot(factor, held, factor, held, held, free))
    if not left > DEPENDENT * vector(search, NORM)[row]:
        return False
    make_reflector(factor, held, u, held, free, left)
    integers(search, REACH)[held] = free
    integers(search, PLACE)[held] = row
    return True


@compiled
def let_go(rows: Block, search: Block, place_of_it: int) -> None:
    """Let the row at a place go, and eliminate those behind it anew."""
    numbers, place, rest = integers(search, NUMBERS), integers(search, PLACE), vector(search, REST)
    factor, reduced, u = matrix(search, FACTOR), matrix(search, REDUCED), matrix(search, REFLECTORS)
    free, last = numbers[FREE], numbers[HELD] - 1
    integers(search, SIDE)[place[place_of_it]] = 0
    held = place_of_it
    for k in range(place_of_it, last):
        row = place[k + 1]
        rest[held] = rest[k + 1]
        copy_row(factor, held, reduced, row, free)
        for j in range(held):
            reflect(factor, held, u, j, free)
        if append(search, held, row, free):
            held += 1
        else:
            integers(search, SIDE)[row] = 0
    numbers[HELD] = held


@compiled
def solve_held(search: Block, basis: int) -> None:
    """Fill next_v with the nearest point under the held rows, and their multipliers."""
    numbers, factor, u = (
        integers(search, NUMBERS),
        matrix(search, FACTOR),
        matrix(search, REFLECTORS),
    )
    toward, along, turned = vector(search, TOWARD), vector(search, ALONG), vector(search, TURNED)
    multiplier, next_v, Z = (
        vector(search, MULTIPLIER),
        vector(search, NEXT_V),
        matrix(search, basis),
    )
    free, held, n = numbers[FREE], numbers[HELD], Z.shape[1]
    copy_vector(toward, vector(search, GOAL), free)
    for j in range(held):
        reflect_vector(toward, u, j, free)
    reach_in_turn(search, 0, 0, held)
    for j in range(free):
        turned[j] = along[j] if j < held else toward[j]
    for i in range(held):
        multiplier[i] = toward[i] - along[i]
    solve_transposed(factor, multiplier, held)
    turn_back(search, held, free)
    copy_vector(next_v, vector(search, POINT), n)
    for k in range(free):
        scale = turned[k]
        for c in range(column(n)):
            next_v[c] += scale * Z[k, c]


@inlined
def solve_transposed(factor: np.ndarray, x: np.ndarray, size: int) -> None:
    """Solve L^T y = x in place, L the lower triangle of the factor."""
    for i in range(size - 1, -1, -1):
        x[i] /= factor[i, i]
        for k in range(column(i)):
            x[k] -= factor[i, k] * x[i]


@compiled
def inverse_column(search: Block, held: int, j: int) -> float:
    """Return the norm of a column of the inverse of the triangle of held rows."""
    factor, scratch = matrix(search, FACTOR), vector(search, SHARE)
    squares = 0.0
    for i in range(j, held):
        rest = 1.0 if i == j else 0.0
        for k in range(j, i):
            rest -= factor[i, k] * scratch[k]
        scratch[i] = rest / factor[i, i]
        squares += scratch[i] ** 2
    return np.sqrt(squares)


@compiled
def most_wrong(search: Block, size: float) -> int:
    """Return the place of the held inequality whose multiplier has most the wrong sign, or -1.

    `size` is that of z and of the goal.
    """
    held, place, side = (
        integers(search, NUMBERS)[HELD],
        integers(search, PLACE),
        integers(search, SIDE),
    )
    multiplier, norm = vector(search, MULTIPLIER), vector(search, NORM)
    wrong, worst = -1, 0.0
    for i in range(held):
        row = place[i]
        if side[row] == EQUALITY:
            continue
        push = -multiplier[i] * side[row]
        if push * norm[row] > worst and push > ROUNDING * size * inverse_column(search, held, i):
            wrong, worst = i, push * norm[row]
    return wrong
