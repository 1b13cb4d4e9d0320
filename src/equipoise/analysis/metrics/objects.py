"""Numbers about bodies that move by themselves: how they leaned, where they ended, at what speed.

Each function returns None if the run has no such body.
"""

from __future__ import annotations

import numpy as np

from equipoise.analysis.metrics.base import Metric
from equipoise.analysis.run_context import RunContext
from equipoise.kinematics import KinematicsEvaluator
from equipoise.scenarios import schema
from equipoise.spatial import POSE_SIZE, Array

EVERY = 10  # ticks from one look at a held object to the next
_TILT, _SPEED = POSE_SIZE, POSE_SIZE + 1  # columns of an object's log, after its pose


def objects_of(context: RunContext) -> dict[str, Array]:
    """Return by name the log (N, 9) of each loose object."""
    run = context.run
    return {n.removeprefix("object/"): run[n] for n in run.names if n.startswith("object/")}


def object_tilt(context: RunContext) -> float | None:
    """Return the largest lean [rad] of an object at any time, by its first palm if it is held."""
    found = objects_of(context)
    leans = [float(log[:, _TILT].max()) for log in found.values()]
    leans += [_held_tilt(context, n) for n in context.scenario.world.objects if n not in found]
    return max(leans, default=None)


def _held_tilt(context: RunContext, name: str) -> float:
    """Return the largest lean [rad], at every tenth tick, of an object that goes with a palm."""
    end, evaluator = np.inf, KinematicsEvaluator(context.setup.robot)
    for spec in context.scenario.contacts.values():
        if isinstance(spec, schema.GraspContactSpec) and spec.object == name and spec.end:
            end = spec.end
    palm = next(hand for held, hand in context.setup.handles if held == name)
    turns = [
        evaluator.at(q).placement(palm).rotation.copy()
        for q in context.run["q"][context.run.t <= end][::EVERY]
    ]
    if not turns:
        return 0.0
    x, y, z = (np.array(turns) @ turns[0].T[:, 2]).T  # what was upright at the start
    return float(np.arctan2(np.hypot(x, y), z).max())


def object_end_speed(context: RunContext) -> float | None:
    """Return the largest speed [m/s] of an object over the last tenth of a second."""
    last = context.run.t >= context.run.t[-1] - 0.1
    logs = objects_of(context).values()
    return max((float(log[last, _SPEED].max()) for log in logs), default=None)


def object_end_error(context: RunContext) -> float | None:
    """Return how far [m] an object ended from where it was wanted."""
    errors = []
    for name, log in objects_of(context).items():
        target = context.setup.targets[name].at(float(context.run.t[-1]))
        errors.append(float(np.linalg.norm(log[-1, :3] - target.T_world_target.translation)))
    return max(errors, default=None)


METRICS = (
    Metric("object_tilt", "rad", "largest lean of a free or held object", object_tilt),
    Metric("object_end_error", "m", "free object from its target at the end", object_end_error),
    Metric("object_end_speed", "m/s", "its speed in the last 0.1 s", object_end_speed),
)
