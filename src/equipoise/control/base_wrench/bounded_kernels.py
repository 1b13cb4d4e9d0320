"""Kernel of the bounded distribution: a hierarchy of four, wrench, floor, motors, cost.

The unknown is y = cost * (lam - wish), lam the predicted reaction, so that the cheapest change of
what is wished is the least y: level 0 carries the base wrench, level 1 keeps what a floor can give
as well as that allows, level 2 the torques of the joints that carry within what their motors give,
and what is still free is least.
"""

from __future__ import annotations

import numpy as np

from equipoise.compiled import compiled
from equipoise.compiled.workspace import Arrays, Block, Shape, integers, matrix, vector
from equipoise.hqp.solvers.active_set.memory import A_ROWS, FIRST, LAST, LOWER, UPPER, V
from equipoise.hqp.solvers.active_set.solve import solve_there

BOUNDS = Arrays(
    ("sides", "limits", "near_since", "predicted", "numbers", "carriers"), frozenset({"carriers"})
)
SIDES, LIMITS, NEAR_SINCE, PREDICTED, NUMBERS, CARRIERS = range(len(BOUNDS.names))
# entries of `numbers`: how near [N] to a bound is told, from when on [s], of the last tick the
# largest violation of a bound [N] and whether the hierarchy was solved, and the share of their
# torque that motors are asked for
WARN, LANDED, SLACK, STATUS, TORQUE_SHARE = range(5)
WORK_LIMIT = 200


def bounds_shapes(rows: int, unknowns: int, joints: int) -> list[tuple[str, Shape, bool]]:
    """Return the arrays: the bounds are `sides lam >= limits`.

    `near_since` [rows] is when a bound was first nearly met, or infinite. `carriers` [joints] are
    the numbers of the joints whose torque depends on the reactions, then -1.
    """
    m = max(rows, 1)
    return BOUNDS.shapes(
        sides=(m, unknowns), limits=m, near_since=m, predicted=unknowns, numbers=5,
        carriers=max(joints, 1),
    )  # fmt: skip


@compiled
def bounded_reaction(
    bounds: Block, rows: Block, search: Block, J: np.ndarray, supporting: np.ndarray, u: np.ndarray,
    costs: np.ndarray, without: np.ndarray, wish: np.ndarray, found: np.ndarray, left: float,
    tau_max: np.ndarray, base: int, t: float, F: np.ndarray,
) -> None:  # fmt: skip
    """Write the reaction F [k] within bounds that carries the first `base` entries of u.

    `wish` [k] is the reaction that costs nothing. What `found` [k] violates, which was measured, is
    forgiven by the share `left`. Where no bound is met F is that of `least_reaction` at the same
    `costs` [k] for `without - wish`. The torque of a joint is what is left of its entry of u, at
    most the share of its entry of `tau_max`.
    """
    A, lower, upper = matrix(rows, A_ROWS), vector(rows, LOWER), vector(rows, UPPER)
    limits = vector(bounds, LIMITS)
    sides, first, last = matrix(bounds, SIDES), integers(rows, FIRST), integers(rows, LAST)
    predicted, numbers, count = vector(bounds, PREDICTED), vector(bounds, NUMBERS), F.shape[0]
    for i in range(base):
        lower[i] = u[i]
        for k in range(count):
            A[i, k] = J[supporting[k], i] / costs[k]
            lower[i] += J[supporting[k], i] * (without[k] - wish[k])
        upper[i] = lower[i]
    for i in range(base, base + sides.shape[0]):
        violated = lower[i] = limits[i - base]
        for k in range(first[i], last[i]):
            A[i, k] = sides[i - base, k] / costs[k]
            lower[i] -= sides[i - base, k] * wish[k]
            violated -= sides[i - base, k] * found[k]
        if violated > 0.0:
            lower[i] -= left * violated
    motor_rows(bounds, rows, J, supporting, u, costs, without, wish, found, left, tau_max, base)
    numbers[STATUS] = solve_there(rows, search, WORK_LIMIT)
    y = vector(search, V)
    for k in range(count):
        predicted[k] = y[k] / costs[k] + wish[k]
        F[k] = predicted[k] - without[k]
    watch(bounds, A, lower, y, base, t)


@compiled
def motor_rows(
    bounds: Block, rows: Block, J: np.ndarray, supporting: np.ndarray, u: np.ndarray,
    costs: np.ndarray, without: np.ndarray, wish: np.ndarray, found: np.ndarray, left: float,
    tau_max: np.ndarray, base: int,
) -> None:  # fmt: skip
    """Write the rows of the joints that carry, as bounds on y: `|u - J^T F| <= share tau_max`.

    What the reaction that was found would take beyond that is forgiven by the share `left`.
    """
    A, lower, upper = matrix(rows, A_ROWS), vector(rows, LOWER), vector(rows, UPPER)
    first, last, carriers = integers(rows, FIRST), integers(rows, LAST), integers(bounds, CARRIERS)
    start, share = base + matrix(bounds, SIDES).shape[0], vector(bounds, NUMBERS)[TORQUE_SHARE]
    for n in range(carriers.shape[0]):
        joint, row = carriers[n], start + n
        if joint < 0:
            break
        free = taken = u[base + joint]
        for k in range(without.shape[0]):
            free += J[supporting[k], base + joint] * (without[k] - wish[k])
            taken += J[supporting[k], base + joint] * (without[k] - found[k])
        for k in range(first[row], last[row]):
            A[row, k] = J[supporting[k], base + joint] / costs[k]
        limit = share * tau_max[joint]
        limit += left * max(abs(taken) - limit, 0.0)
        lower[row], upper[row] = free - limit, free + limit


@compiled
def watch(
    bounds: Block, A: np.ndarray, lower: np.ndarray, y: np.ndarray, base: int, t: float
) -> None:
    """Note the largest violation, and since when each bound has been near."""
    numbers, since = vector(bounds, NUMBERS), vector(bounds, NEAR_SINCE)
    numbers[SLACK] = 0.0
    for i in range(base, base + since.shape[0]):
        if lower[i] == -np.inf:
            continue
        margin = -lower[i]
        for k in range(y.shape[0]):
            margin += A[i, k] * y[k]
        numbers[SLACK] = max(numbers[SLACK], -margin)
        if margin < numbers[WARN] and t >= numbers[LANDED] and since[i - base] == np.inf:
            since[i - base] = t
