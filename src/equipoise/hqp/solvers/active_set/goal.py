"""Compiled goals: a level of unit rows with equal weights is reached in closed form.

Such a level (a posture) asks c v_J = c g for some of the unknowns, J. With v = point + z Z, Z
orthonormal, it minimises |z Z_J - (g - point_J)|, and Z_J Z_J^T = I - Z_B Z_B^T, where B are the
other columns, six of a base as a rule. With the Cholesky factor C C^T of this matrix the rows of
C^-1 Z are orthonormal in the columns J: in their coordinates the level asks for the nearest point
to the goal, as the least norm does in those of Z (there J are all columns and g is zero). Where
that matrix is nearly singular, the level does not determine all directions, and counts as others.
"""

from __future__ import annotations

from equipoise.compiled.compilation import compiled, inlined
from equipoise.compiled.workspace import Block, integers, matrix, vector
from equipoise.hqp.solvers.active_set.memory import (
    A_ROWS,
    BASIS,
    BASIS_NUMBER,
    FREE,
    GOAL,
    LAST_V,
    LOWER,
    NUMBERS,
    OUT,
    POINT,
    ROLE,
    SINGLE,
    SQUARE,
    STEP,
    TURNED,
    UPPER,
    WHITE,
)
from equipoise.hqp.solvers.active_set.primitives import column, copy_row, factorise, length

FAR_AWAY = 10.0
LEAST_PIVOT = 1e-2  # of I - Z_B Z_B^T: below it rounding would be magnified


@compiled
def is_goal(rows: Block, search: Block, start: int, end: int) -> bool:
    """Tell whether a level has only unit rows of equal weight, each of another unknown."""
    A, single, role = matrix(rows, A_ROWS), integers(rows, SINGLE), integers(search, ROLE)
    low, high, seen = vector(rows, LOWER), vector(rows, UPPER), vector(search, TURNED)
    for c in range(A.shape[1]):
        seen[c] = 0.0
    weight = 0.0
    for row in range(start, end):
        if role[row] == OUT:
            continue
        place = single[row]
        if place < 0 or low[row] != high[row] or seen[place] != 0.0:
            return False
        scale = abs(A[row, place])
        if scale == 0.0 or (weight != 0.0 and scale != weight):
            return False
        weight, seen[place] = scale, 1.0
    return weight > 0.0


@compiled
def nearest_to_zero(search: Block) -> None:
    """Write the coordinates of the least v as the goal."""
    Z, goal, point = matrix(search, BASIS), vector(search, GOAL), vector(search, POINT)
    for k in range(integers(search, NUMBERS)[FREE]):
        total = 0.0
        for c in range(column(Z.shape[1])):
            total -= Z[k, c] * point[c]
        goal[k] = total


@compiled
def nearest_to_last(search: Block, size: float) -> None:
    """Write the coordinates of the last answer as the goal, or of where we stand.

    An answer that was much larger than `size` would cost this one its last digits.
    """
    Z, goal, point = matrix(search, BASIS), vector(search, GOAL), vector(search, POINT)
    last = vector(search, LAST_V)
    usable = length(last, last.shape[0]) <= FAR_AWAY * size
    for k in range(integers(search, NUMBERS)[FREE]):
        total = 0.0
        for c in range(column(Z.shape[1])):
            total += Z[k, c] * (last[c] - point[c])
        goal[k] = total if usable else 0.0


@compiled
def whiten(rows: Block, search: Block, start: int, end: int) -> bool:
    """Write the white basis of a goal and the goal in its coordinates.

    Returns False where the goal does not determine every direction well.
    """
    Z, white, numbers = matrix(search, BASIS), matrix(search, WHITE), integers(search, NUMBERS)
    square, free, n = matrix(search, SQUARE), numbers[FREE], Z.shape[1]
    wanted = vector(search, STEP)
    others = take_goal(rows, search, start, end)
    if others > n - free:  # then some direction moves none of J
        return False
    multiply_others(search, free)
    if not factorise(square, free, LEAST_PIVOT):
        return False
    for k in range(free):
        copy_row(white, k, Z, k, n)
    goal = vector(search, GOAL)
    for k in range(free):
        for i in range(k):
            scale = square[k, i]
            for c in range(column(n)):
                white[k, c] -= scale * white[i, c]
        scale, total = square[k, k], 0.0
        for c in range(column(n)):
            white[k, c] *= scale
            total += white[k, c] * wanted[c]
        goal[k] = total
    numbers[BASIS_NUMBER] += 1
    return True


@inlined
def take_goal(rows: Block, search: Block, start: int, end: int) -> int:
    """Write the wanted change of v to `step`, a 1 to `turned` for the others; return how many."""
    A, single, role = matrix(rows, A_ROWS), integers(rows, SINGLE), integers(search, ROLE)
    others, wanted = vector(search, TURNED), vector(search, STEP)
    low, point = vector(rows, LOWER), vector(search, POINT)
    n = A.shape[1]
    for c in range(n):
        others[c], wanted[c] = 1.0, 0.0
    count = n
    for row in range(start, end):
        if role[row] != OUT:
            place = single[row]
            wanted[place], others[place] = low[row] / A[row, place] - point[place], 0.0
            count -= 1
    return count


@inlined
def multiply_others(search: Block, free: int) -> None:
    """Write the lower half of I - Z_B Z_B^T."""
    Z, square, others = matrix(search, BASIS), matrix(search, SQUARE), vector(search, TURNED)
    for i in range(free):
        for k in range(i):
            square[i, k] = 0.0
        square[i, i] = 1.0
    for c in range(Z.shape[1]):
        if others[c] == 0.0:
            continue
        for i in range(free):
            scale = Z[i, c]
            for k in range(i + 1):
                square[i, k] -= scale * Z[k, c]
