"""Compiled approach to the optimum of a level by Newton steps: cheap, and nobody relies on it.

Half the squared violation is piecewise quadratic. A step solves the normal equations of the own
rows at work, in the coordinates of the basis that the held rows leave free, and goes on as long as
the violation falls and the hard rows allow. The sum of squares is kept from step to step, so that a
row that comes in or goes out costs little. Normal equations lose half the digits, and a little is
added to them so that directions that hardly matter are not gone along: which rows work is what
comes out, and `descend` takes it from there with a factor that keeps all digits.
"""

from __future__ import annotations

from equipoise.compiled.compilation import compiled, inlined
from equipoise.compiled.workspace import Block, integers, matrix, vector
from equipoise.hqp.solvers.active_set.elimination import turn_back
from equipoise.hqp.solvers.active_set.line import least_along, move, reach
from equipoise.hqp.solvers.active_set.memory import (
    BASIS,
    DEPENDENT,
    FEASIBILITY,
    FREE,
    HARD,
    HELD,
    INVERSE,
    LOWER,
    MIX,
    NEXT_V,
    NEXT_VALUE,
    NORM,
    NUMBERS,
    OWN,
    RATE,
    REDUCED,
    REFLECTORS,
    ROLE,
    SHARE,
    SIDE,
    SMALLEST,
    SQUARE,
    STEP,
    TURNED,
    UPPER,
    VALUE,
    V,
)
from equipoise.hqp.solvers.active_set.primitives import (
    column,
    copy_row,
    dot,
    factorise,
    length,
    reflect,
    solve_factorised,
)
from equipoise.hqp.solvers.active_set.values import (
    bound_of,
    norm_of,
    reduce_row,
    side_of,
    value_of,
)

STEPS = 20
TOO_FAR = 1e4  # times the size of v: a step that would cost digits
ADDED = 1e-8  # to the sum of squares, as a share of its largest


@compiled
def approach(rows: Block, search: Block, start: int, end: int) -> tuple[int, int]:
    """Bring v nearer to the optimum of the own rows start..end, the held rows kept.

    Values at v are filled before and after; the held rows have been eliminated. Returns the hard
    row that stands in the way and the side, -1 for none.
    """
    v, n = vector(search, V), vector(search, V).shape[0]
    bend_rows(rows, search, start, end)
    sum_squares(search, start, end)
    for _ in range(STEPS):
        if not take_step(rows, search, start, end):
            break
        size = max(length(v, n), SMALLEST)
        if length(vector(search, STEP), n) > TOO_FAR * size:
            break
        most, row, side = reach(rows, search, end, size, False)
        share = least_along(rows, search, start, end, most)
        move(search, share, end)
        size = max(length(v, n), SMALLEST)
        changed = change(rows, search, start, end, size)
        if row >= 0 and share == most:
            return row, side
        if not changed:
            break
    return -1, 0


@inlined
def bend_rows(rows: Block, search: Block, start: int, end: int) -> None:
    """Write the own rows in the coordinates that the held rows leave free to `mix`, by row."""
    bent, reduced, u = matrix(search, MIX), matrix(search, REDUCED), matrix(search, REFLECTORS)
    role, numbers = integers(search, ROLE), integers(search, NUMBERS)
    free, held = numbers[FREE], numbers[HELD]
    for row in range(start, end):
        if role[row] == OWN:
            reduce_row(rows, search, BASIS, row, free)
            copy_row(bent, row, reduced, row, free)
    for j in range(held):
        for row in range(start, end):
            if role[row] == OWN:
                reflect(bent, row, u, j, free)
    norm = vector(search, NORM)
    for row in range(start, end):
        if role[row] == OWN:
            left = dot(bent, row, bent, row, held, free)
            if not left > (DEPENDENT * norm[row]) ** 2:
                for k in range(held, free):
                    bent[row, k] = 0.0


@inlined
def sum_squares(search: Block, start: int, end: int) -> None:
    """Sum m^T m over the own rows at work."""
    role, side, square = integers(search, ROLE), integers(search, SIDE), matrix(search, SQUARE)
    free = integers(search, NUMBERS)[FREE]
    for i in range(free):
        for k in range(column(free)):
            square[i, k] = 0.0
    for row in range(start, end):
        if role[row] == OWN and side[row] != 0:
            add_square(search, row, 1.0)


@compiled
def add_square(search: Block, row: int, weight: float) -> None:
    """Add a row's m^T m to the sum, lower half."""
    bent, square, numbers = matrix(search, MIX), matrix(search, SQUARE), integers(search, NUMBERS)
    first = numbers[HELD]
    for i in range(first, numbers[FREE]):
        scale = weight * bent[row, i]
        if scale != 0.0:
            for k in range(column(first), column(i + 1)):
                square[i, k] += scale * bent[row, k]


@inlined
def take_step(rows: Block, search: Block, start: int, end: int) -> bool:
    """Fill the step, next_v and the values there; False if there is nowhere to go."""
    factor, square, numbers = (
        matrix(search, INVERSE),
        matrix(search, SQUARE),
        integers(search, NUMBERS),
    )
    first, free = numbers[HELD], numbers[FREE]
    size, most = free - first, 0.0
    for i in range(first, free):
        most = max(most, square[i, i])
    for i in range(size):
        for k in range(i):
            factor[i, k] = square[first + i, first + k]
        factor[i, i] = square[first + i, first + i] + ADDED * most
    if not factorise(factor, size, 0.0):
        return False
    pull(rows, search, start, end, first, free)
    solve_factorised(factor, vector(search, SHARE), size)
    spread(rows, search, start, end, first, free)
    return True


@inlined
def pull(rows: Block, search: Block, start: int, end: int, first: int, free: int) -> None:
    """Write to `share` the sum of -m w over the own rows that are violated."""
    bent, out, value = matrix(search, MIX), vector(search, SHARE), vector(search, VALUE)
    low, high, role = vector(rows, LOWER), vector(rows, UPPER), integers(search, ROLE)
    for k in range(free - first):
        out[k] = 0.0
    for row in range(start, end):
        if role[row] == OWN:
            beyond = value[row] - min(max(value[row], low[row]), high[row])
            if beyond != 0.0:
                for k in range(column(free - first)):
                    out[k] -= beyond * bent[row, column(first) + k]


@inlined
def spread(rows: Block, search: Block, start: int, end: int, first: int, free: int) -> None:
    """Turn the coordinates in `share` into the step, next_v and the values there."""
    turned, out, Z = vector(search, TURNED), vector(search, SHARE), matrix(search, BASIS)
    step, v, next_v = vector(search, STEP), vector(search, V), vector(search, NEXT_V)
    role, bent = integers(search, ROLE), matrix(search, MIX)
    value, next_value, rates = (
        vector(search, VALUE),
        vector(search, NEXT_VALUE),
        vector(search, RATE),
    )
    low, high, n = vector(rows, LOWER), vector(rows, UPPER), v.shape[0]
    for row in range(start, end):
        if role[row] == OWN:
            rate = 0.0
            for k in range(column(free - first)):
                rate += out[k] * bent[row, column(first) + k]
            rates[row], next_value[row] = rate, value[row] + rate
    for k in range(free):
        turned[k] = out[k - first] if k >= first else 0.0
    turn_back(search, first, free)
    for c in range(n):
        step[c] = 0.0
    for k in range(free):
        scale = turned[k]
        for c in range(column(n)):
            step[c] += scale * Z[k, c]
    for c in range(n):
        next_v[c] = v[c] + step[c]
    for row in range(start):
        if role[row] == HARD:
            rates[row] = 0.0 if low[row] == high[row] else value_of(rows, row, step)
            next_value[row] = value[row] + rates[row]


@inlined
def change(rows: Block, search: Block, start: int, end: int, size: float) -> bool:
    """Take own rows to work and from work by their values; tell whether there were any."""
    low, high, value = vector(rows, LOWER), vector(rows, UPPER), vector(search, VALUE)
    role, side, changed = integers(search, ROLE), integers(search, SIDE), False
    for row in range(start, end):
        if role[row] != OWN or low[row] == high[row]:
            continue
        if side[row] == 0 and value[row] <= high[row] and value[row] >= low[row]:
            continue
        margin = FEASIBILITY * norm_of(rows, row) * size
        new = side_of(low[row], high[row], value[row], margin)
        if new == 0 and side[row] != 0:  # where it works it stays while it is there
            at_it = bound_of(rows, row, side[row])
            new = side[row] if abs(value[row] - at_it) <= margin else 0
        if new != side[row]:
            add_square(search, row, float(abs(new) - abs(side[row])))
            side[row] = new
            changed = True
    return changed
