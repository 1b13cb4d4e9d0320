"""How near the run came to what joints, motors and bodies allow."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from equipoise.analysis.metrics.base import Found, Metric, least, most
from equipoise.analysis.metrics.clearance import Clearance, least_clearance, touching_pairs
from equipoise.analysis.run_context import RunContext
from equipoise.scenarios import schema

REST = 0.01  # [s] without a clamped torque after which a new stretch begins


def _torque_step(context: RunContext) -> float | None:
    tau = context.run["tau"][context.settled]
    if len(tau) < 2:
        return None
    return float((np.abs(np.diff(tau, axis=0)) / context.setup.robot.tau_max).max())


def _security_shortfall(context: RunContext) -> float | None:
    shortfalls = []
    labels = context.run.channels["distance"].labels
    for spec in context.scenario.tasks.values():
        if isinstance(spec, schema.AvoidanceSpec) and spec.enabled:
            columns = [labels.index(f"{a} - {b}") for a, b in spec.pairs]
            shortfalls.append(spec.security - float(context.run["distance"][:, columns].min()))
    return max(shortfalls, default=None)


def _clearance(context: RunContext) -> Found | None:
    return _sampled(least_clearance(context.run, context.setup), context)


def _touch_depth(context: RunContext) -> Found | None:
    touching = least_clearance(context.run, context.setup, touching_pairs)
    if touching is None:
        return None
    deepest = replace(touching, distance=-touching.distance, distances=-touching.distances)
    return _sampled(deepest, context)


def _sampled(clearance: Clearance | None, context: RunContext) -> Found | None:
    """Return distances at some ticks as a series in which the ticks between are as those before."""
    if clearance is None:
        return None
    where = np.searchsorted(clearance.ticks, np.arange(len(context.run.t)), side="right") - 1
    names = [clearance.pairs[k] for k in where]
    return Found(clearance.distance, clearance.distances[where], names)


def _joint_margin(context: RunContext) -> Found | None:
    robot = context.setup.robot
    q = context.run["q"][:, robot.nq_base :]
    return least(list(np.minimum(q - robot.q_min, robot.q_max - q).T), robot.joint_names)


def _velocity_share(context: RunContext) -> Found | None:
    robot = context.setup.robot
    speeds = np.abs(context.run["v"][:, robot.nv_base :]) / robot.v_max
    return most(list(speeds.T), robot.joint_names)


def _torque_share(context: RunContext) -> Found | None:
    robot = context.setup.robot
    return most(list((np.abs(context.run["tau"]) / robot.tau_max).T), robot.joint_names)


def _torque_effort(context: RunContext) -> float | None:
    tau = context.run["tau"][context.settled]
    if not len(tau):
        return None
    return float(np.sqrt(((tau / context.setup.robot.tau_max) ** 2).mean()))


def _clamped_longest(context: RunContext) -> Found:
    """For how long [s] a torque stood at its limit without a rest, as it grows tick by tick.

    A rest is at least `REST` long: a torque that flips from limit to limit has none.
    """
    clamped, t = context.run["status"][:, 0] >= 1.0, context.run.t
    period = context.scenario.control.period
    series, began, last = np.zeros(len(t)), 0.0, -np.inf
    for k in np.flatnonzero(clamped):
        if t[k] - last > REST:
            began = t[k]
        last = t[k]
        series[k] = t[k] - began + period
    robot = context.setup.robot
    worst = np.argmax(np.abs(context.run["tau"]) / robot.tau_max, axis=1)
    return Found(float(series.max()), series, [robot.joint_names[j] for j in worst])


def _status_count(column: int, code: float) -> Callable[[RunContext], float]:
    return lambda context: float((context.run["status"][:, column] >= code).sum())


METRICS = (
    Metric("torque_step", "", "largest change of a torque in a tick, by its limit", _torque_step),
    Metric("clearance", "m", "least distance of any pair of bodies, every 10th tick", _clearance),
    Metric(
        "touch_depth", "m", "how far a link is inside of what its contact touches", _touch_depth
    ),
    Metric(
        "security_shortfall", "m", "worst intrusion into a security distance", _security_shortfall
    ),
    Metric("joint_margin", "rad", "least distance to a joint position limit", _joint_margin),
    Metric("velocity_share", "", "largest share of a joint velocity limit", _velocity_share),
    Metric("torque_share", "", "largest share of a torque limit", _torque_share),
    Metric("torque_effort", "", "torques as shares of their limits, RMS, settled", _torque_effort),
    Metric("saturated_ticks", "", "ticks with a clamped torque or worse", _status_count(0, 1.0)),
    Metric("clamped_longest", "s", "longest time with a clamped torque or worse", _clamped_longest),
    Metric("held_ticks", "", "ticks on which the last torque was kept", _status_count(0, 2.0)),
    Metric("unsolved_ticks", "", "ticks with an unsolved hierarchy", _status_count(1, 1.0)),
)
