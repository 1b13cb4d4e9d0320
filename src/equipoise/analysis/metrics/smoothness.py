"""How smooth the reference was: how much its joint accelerations changed."""

from __future__ import annotations

import numpy as np

from equipoise.analysis.metrics.base import Found, Metric, most
from equipoise.analysis.run_context import RunContext
from equipoise.spatial import Array


def acceleration_steps(v: Array, period: float) -> Array:
    """Return by how much `dv/dt` [rad/s^2] changed at each tick, for velocities `v` (N, k).

    The size of the second differences of v over the `period` [s], (N - 2, k): their sum is the
    total variation of the acceleration, the integral of the size of the jerk.
    """
    return np.abs(np.diff(v, n=2, axis=0)) / period


def _steps(context: RunContext) -> Array | None:
    if "v_ref" not in context.run or len(context.run.t) < 3:
        return None
    v = context.run["v_ref"][:, context.setup.robot.nv_base :]
    return acceleration_steps(v, context.scenario.control.period)


def _roughness(context: RunContext) -> float | None:
    steps = _steps(context)
    return None if steps is None else float(steps.sum())


def _jerk(context: RunContext) -> Found | None:
    steps = _steps(context)
    if steps is None:
        return None
    ends = np.zeros((1, steps.shape[1]))  # the first and the last tick have a neighbour less
    jerk = np.vstack((ends, steps, ends)) / context.scenario.control.period
    return most(list(jerk.T), context.setup.robot.joint_names)


METRICS = (
    Metric(
        "reference_roughness",
        "rad/s^2",
        "total variation of the reference's joint accelerations, all joints together",
        _roughness,
    ),
    Metric("reference_jerk", "rad/s^3", "largest jerk of a joint of the reference", _jerk),
)
