"""A posture that meets a hierarchy of tasks: the hierarchy followed until it rests."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from equipoise.errors import InputError
from equipoise.hqp import HierarchySolver
from equipoise.kinematics import KinematicsEvaluator
from equipoise.motion.building import HierarchyBuilder
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.tasks import Task

_MUST_BE_BELOW = 1e-4  # [m, rad] how far a task that must hold may be off


class PostureNotFoundError(InputError):
    """No posture meets the tasks that were asked for; says which and by how much."""


def solve_posture(
    robot: Robot,
    levels: Sequence[Sequence[Task]],
    solver: HierarchySolver,
    q_from: Array,
    *,
    t_from: float,
    step: float = 0.02,
    iterations: int = 3000,
    tolerance: float = 1e-5,
    must_hold: Sequence[Task] = (),
) -> Array:
    """Follow the hierarchy from `q_from` (nq,) at time `t_from` <= 0 to time 0, then to rest.

    Targets that move during negative time lead the robot to where time 0 wants it; after that
    they are frozen. It rests when the largest velocity is below `tolerance` [rad/s, m/s].
    `step` [s] is one Euler step; rates of the tasks times `step` must stay below 1.
    Returns: the configuration (nq,).
    Raises: `PostureNotFoundError` if a task of `must_hold` is violated at the end.
    """
    evaluator, builder = KinematicsEvaluator(robot), HierarchyBuilder(levels)
    q, v = np.array(q_from, dtype=float), np.zeros(robot.nv)
    for k in range(iterations):
        t = min(0.0, t_from + k * step)
        v = solver.solve(builder.at(evaluator.at(q, v, t), t)).v
        q = pin.integrate(robot.model, q, v * step)
        if t == 0.0 and np.abs(v).max() < tolerance:
            break
    _require(must_hold, evaluator, q)
    return q


def _require(tasks: Sequence[Task], evaluator: KinematicsEvaluator, q: Array) -> None:
    kin = evaluator.at(q, np.zeros(evaluator.robot.nv))
    for task in tasks:
        error = np.abs(task.error(kin, 0.0))
        worst = int(np.argmax(error))
        if error[worst] > _MUST_BE_BELOW:
            raise PostureNotFoundError(
                f"no starting posture meets task {task.name!r}: {task.labels[worst]} is off by "
                f"{error[worst]:.4g} {task.units[worst]}",
                remedy="Move the first waypoint or the objects, or loosen the tasks above it",
            )
