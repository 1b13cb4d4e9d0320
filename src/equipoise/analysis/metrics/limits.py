"""How near the run came to what joints, motors and bodies allow."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from equipoise.analysis.metrics.base import Metric
from equipoise.analysis.metrics.clearance import least_clearance
from equipoise.analysis.run_context import RunContext
from equipoise.scenarios import schema


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


def _clearance(context: RunContext) -> float | None:
    found = least_clearance(context.run, context.setup)
    return found.distance if found is not None else None


def _joint_margin(context: RunContext) -> float:
    robot = context.setup.robot
    q = context.run["q"][:, robot.nq_base :]
    return float(np.minimum(q - robot.q_min, robot.q_max - q).min())


def _velocity_share(context: RunContext) -> float:
    robot = context.setup.robot
    return float((np.abs(context.run["v"][:, robot.nv_base :]) / robot.v_max).max())


def _torque_share(context: RunContext) -> float:
    return float((np.abs(context.run["tau"]) / context.setup.robot.tau_max).max())


def _status_count(column: int, code: float) -> Callable[[RunContext], float]:
    return lambda context: float((context.run["status"][:, column] >= code).sum())


METRICS = (
    Metric("torque_step", "", "largest change of a torque in a tick, by its limit", _torque_step),
    Metric("clearance", "m", "least distance of any pair of bodies, every 10th tick", _clearance),
    Metric(
        "security_shortfall", "m", "worst intrusion into a security distance", _security_shortfall
    ),
    Metric("joint_margin", "rad", "least distance to a joint position limit", _joint_margin),
    Metric("velocity_share", "", "largest share of a joint velocity limit", _velocity_share),
    Metric("torque_share", "", "largest share of a torque limit", _torque_share),
    Metric("saturated_ticks", "", "ticks with a clamped torque or worse", _status_count(0, 1.0)),
    Metric("held_ticks", "", "ticks on which the last torque was kept", _status_count(0, 2.0)),
    Metric("unsolved_ticks", "", "ticks with an unsolved hierarchy", _status_count(1, 1.0)),
)
