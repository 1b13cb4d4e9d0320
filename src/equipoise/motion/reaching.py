"""How hands go for what is out of reach: arms before legs, so slowly that a robot still stands."""

from __future__ import annotations

from typing import Any

import numpy as np

from equipoise.motion.acceleration_advice import borne_inertia
from equipoise.robots import Robot, require_robot
from equipoise.spatial import Array
from equipoise.spatial.numbers import real_vector
from equipoise.tasks import Reach

HEAVY = 0.75  # power of the inertia by which joints hold back
LIGHT, LIGHT_LIVE = 1.0, 0.1  # [kg m^2] up to which joints are light: on planned ways, of live ones
# [rad/s^2], [rad/s] of a light joint, on a way that is planned to be calm
CALM_CHANGE, CALM_FASTEST = 2.5, 0.4
LIVE_CHANGE, LIVE_FASTEST = 10.0, 0.5  # the same for a live target that is not followed well
CLOSE = 0.005  # [m] from a live target, within which joints may be faster
HOMING = 0.2  # [rad/s] of a light joint


def calm_reach(robot: Robot, period: float, *, calm: bool, **given: float) -> Reach:
    """Return the reach of a frame on a planned way; if `calm`, no joint is fast.

    Joints count by the inertia they move, from 1 kg m^2 on: an arm before a leg. `given` are those
    of `Reach`.
    """
    weights = _weights(robot, robot.q_half_sitting, LIGHT)
    more: dict[str, Any] = dict(given)
    if calm:
        more |= {"change": CALM_CHANGE / weights, "fastest": CALM_FASTEST / weights}
    return Reach(robot, period, weights=weights, **more)


def live_reach(robot: Robot, period: float, q: Array | None = None) -> Reach:
    """Return the reach of a hand whose target is set while it runs and may be out of reach.

    The robot begins at `q` (nq,), half-sitting if None; `period` [s] is that of the loop. The hand
    stretches, waits and comes back, calmly: joints change their speed by at most 10 rad/s^2 over
    their share, trunk and legs by less. A target that is fast is followed less well for it.
    Raises: `InputError`, `ShapeError`.
    """
    require_robot("the robot that reaches", robot)
    q = robot.q_half_sitting if q is None else real_vector("q", q, robot.nq)
    floating = robot.nv_base == 6  # a base to balance
    weights = _weights(robot, q, LIGHT_LIVE) if floating else np.ones(robot.na)
    return Reach(
        robot,
        period,
        weights=weights,
        change=LIVE_CHANGE / weights,
        fastest=LIVE_FASTEST / weights,
        close=CLOSE,
        home=q[robot.nq_base :],
        homing=HOMING,
    )


def _weights(robot: Robot, q: Array, light: float) -> Array:
    weights: Array = np.maximum(borne_inertia(robot, q) / light, 1.0) ** HEAVY
    return weights
