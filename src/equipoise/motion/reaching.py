"""How hands go for what is out of reach: arms before legs, so slowly that a robot still stands."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from equipoise.motion.acceleration_advice import borne_inertia
from equipoise.robots import Robot, require_robot
from equipoise.robots.arm_span import ArmSpan, arm_span
from equipoise.spatial import Array
from equipoise.spatial.numbers import real_vector
from equipoise.tasks import FramePoseTask, Reach, Task
from equipoise.trajectories.live import Ball, LiveTarget

HEAVY = 0.75  # power of the inertia by which joints hold back
LIGHT, LIGHT_LIVE = 1.0, 0.1  # [kg m^2] up to which joints are light: on planned ways, of live ones
# [rad/s^2], [rad/s] of a light joint, on a way that is planned to be calm
CALM_CHANGE, CALM_FASTEST = 2.5, 0.4
LIVE_CHANGE, LIVE_FASTEST = 10.0, 0.5  # the same for a live target that is not followed well
CLOSE = 0.005  # [m] from a live target, within which joints may be faster
HOMING = 0.2  # [rad/s] of a light joint
STEADY = 60.0  # least weight of what is no joint of the arm: an arm is stretched before all else
LEAN = 0.2  # of an arm's length by which a body that floats helps, exactly, by leaning
EDGE = 0.985  # of an arm's length: two equal links are bent by 20 degrees there
# [m/s, m/s^2, rad/s, rad/s^2] of jumps out of reach, and back
PACE = (0.5, 2.0, 1.0, 4.0)


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


def live_reach(
    robot: Robot, period: float, q: Array | None = None, frame: str | int | None = None
) -> Reach:
    """Return the reach of a hand whose target is set while it runs and may be out of reach.

    The robot begins at `q` (nq,), half-sitting if None; `period` [s] is that of the loop. The hand
    stretches, waits and comes back, calmly: joints change their speed by at most 10 rad/s^2 over
    their share, trunk and legs by less. With the `frame` of the hand this is so only for what its
    arm cannot get to; without, a target that is fast is followed less well.
    Raises: `InputError`, `ShapeError`.
    """
    require_robot("the robot that reaches", robot)
    q = robot.q_half_sitting if q is None else real_vector("q", q, robot.nq)
    floating = robot.nv_base == 6  # a base to balance
    weights = _weights(robot, q, LIGHT_LIVE) if floating else np.ones(robot.na)
    span, edges = None, (np.inf, np.inf)
    if frame is not None and (span := arm_span(robot, frame, q)) is not None:
        home = _distance(robot, q, frame, span)
        edges = _edge(span.surely, home), _edge(span.longest, home)
        if floating:
            edges = edges[0], edges[1] + LEAN * span.longest
            others = [joint not in span.joints for joint in range(robot.na)]
            weights[others] = np.maximum(weights[others], STEADY)
    return Reach(
        robot,
        period,
        weights=weights,
        change=LIVE_CHANGE / weights,
        fastest=LIVE_FASTEST / weights,
        close=CLOSE,
        home=q[robot.nq_base :],
        homing=HOMING,
        span=span,
        edges=edges,
    )


def wait_where_out_of_reach(
    robot: Robot, levels: Sequence[Sequence[Task]], q: Array, period: float
) -> None:
    """Let hands whose targets are set while they run wait, stretched, for what is out of reach.

    What was given a reach, or False, keeps it; what has an ease gets none. Jumps that leave the
    ball that the arm reaches, or come back into it, keep a pace.
    """
    for task in (task for level in levels for task in level):
        if not isinstance(task, FramePoseTask) or task.chosen:
            continue
        if not isinstance(task.target, LiveTarget) or task.frame is None:
            continue
        if np.isfinite(task.ease):
            continue  # it knows the velocity of the tick before by itself
        reach = live_reach(robot, period, q, task.frame)
        if reach.span is None:
            continue  # no arm: a foot, a head
        task.wait_where_out_of_reach(reach)
        span = reach.span
        radius = _edge(span.longest, _distance(robot, q, task.frame, span))
        ball = Ball(span.p_world_shoulder, span.p_frame_wrist, radius, reach.edges[1])
        task.target.pace_outside(ball, np.array(PACE))


def _distance(robot: Robot, q: Array, frame: str | int, span: ArmSpan) -> float:
    """Return how far [m] the wrist is from the shoulder at `q` (nq,)."""
    wrist = robot.at(q).placement(frame).act(span.p_frame_wrist)
    return float(np.linalg.norm(wrist - span.p_world_shoulder))


def _edge(length: float, home: float) -> float:
    """Return where [m] what is out of reach begins: where it starts the robot is not."""
    return max(EDGE * length, (home + length) / 2.0)


def _weights(robot: Robot, q: Array, light: float) -> Array:
    weights: Array = np.maximum(borne_inertia(robot, q) / light, 1.0) ** HEAVY
    return weights
