"""Rows of second order: bounds that are come to without a kink, and wishes come to gradually.

A bound `A v <= u` with `u = k d` on a distance d is met with full speed: where it becomes active
the acceleration jumps by `k A v`, and where it lets go it jumps back. With an ease e and a period T
the row is

    A v <= e T u + (1 - e T) (1 - k T) max(A v_before, 0),   and A v <= u as before.

On it, what is left of the bound, `u - A v`, shrinks by exactly the share e T a tick where d falls
by `T A v`: `d'' + (e + k) d' + e k d = 0`, two real rates, so the distance still never becomes
negative. Where the row becomes active, A v has the acceleration of the row already. Standing still
satisfies every eased row whose own bound it satisfies, and so does going on with a share of
v_before of at most `(1 - e T) (1 - k T)`: easing makes nothing infeasible that was feasible at
rest. Under a cap, as a speed limit, k is 0.

A wish `A v = b` becomes `A v = A v_before + e T (b - A v_before)`. In the lowest level it makes
what is left of the freedom a spring with a damper, `a = e (b - A v)`: its answer is the
acceleration nearest to that, and multipliers of bounds end at zero where they let go, so that the
acceleration does not jump there either. What it comes to rest at is what it was.

Source: bounds of second order as exponential barriers (Nguyen and Sreenath 2016), here exact in
discrete time. Differs from the print: a bound on v in the same hierarchy of velocities, with
v_before in place of a measured velocity.
"""

from __future__ import annotations

import numpy as np

from equipoise.compiled import compiled
from equipoise.compiled.workspace import Block, integers, matrix, vector
from equipoise.hqp.solvers.active_set.memory import A_ROWS, LOWER, UPPER
from equipoise.hqp.solvers.active_set.memory import FIRST as ROW_BEGINS
from equipoise.hqp.solvers.active_set.memory import LAST as ROW_ENDS
from equipoise.motion.memory import CLOCK, ROW_CAP, ROW_EASE, ROW_SLOPE, TICK, V_REF


@compiled
def eased(bound: float, speed: float, slope: float, ease: float, dt: float) -> float:
    """Return the eased upper bound of A v, where the speed A v_before was."""
    share = min(ease * dt, 1.0)
    kept = (1.0 - share) * (1.0 - min(slope * dt, 1.0))
    return min(bound, share * bound + kept * max(speed, 0.0))


@compiled
def ease_rows(tasks: Block, rows: Block) -> None:
    """Ease the rows that were just written, where their tasks say so; v_ref is that before."""
    ease, slope, cap = vector(tasks, ROW_EASE), vector(tasks, ROW_SLOPE), vector(tasks, ROW_CAP)
    A, lower, upper = matrix(rows, A_ROWS), vector(rows, LOWER), vector(rows, UPPER)
    first, last = integers(rows, ROW_BEGINS), integers(rows, ROW_ENDS)
    before, dt = vector(tasks, V_REF), vector(tasks, CLOCK)[TICK]
    for row in range(ease.shape[0]):
        low, high = lower[row], upper[row]
        if ease[row] == np.inf or (low == -np.inf and high == np.inf):
            continue  # what a free row says is old
        speed = 0.0
        for c in range(first[row], last[row]):
            speed += A[row, c] * before[c]
        if low == high:
            lower[row] = speed + min(ease[row] * dt, 1.0) * (low - speed)
            upper[row] = lower[row]
            continue
        if high < np.inf:
            falls = slope[row] if abs(high) < cap[row] else 0.0
            upper[row] = max(eased(high, speed, falls, ease[row], dt), low)
        if low > -np.inf:
            falls = slope[row] if abs(low) < cap[row] else 0.0
            lower[row] = min(-eased(-low, -speed, falls, ease[row], dt), high)
