"""A posture that meets a hierarchy of tasks: inverse kinematics to convergence."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from equipoise.errors import InputError
from equipoise.hqp import HierarchySolver
from equipoise.kinematics import KinematicsEvaluator
from equipoise.motion.generator import build_hierarchy
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.tasks import Task


class PostureNotFoundError(InputError):
    """No posture meets the tasks that were asked for; says which and by how much."""


def solve_posture(
    robot: Robot,
    levels: Sequence[Sequence[Task]],
    solver: HierarchySolver,
    q_start: Array,
    *,
    t: float = 0.0,
    step: float = 0.05,
    iterations: int = 4000,
    tolerance: float = 1e-7,
    must_hold: Sequence[Task] = (),
) -> Array:
    """Follow the hierarchy from `q_start` (nq,) at frozen time `t` until it rests; return q (nq,).

    `step` [s] is the length of one Euler step (all task rates times `step` should stay below 1);
    it rests when the largest velocity is below `tolerance` [rad/s, m/s].
    Raises: `PostureNotFoundError` if a task of `must_hold` is then violated by more than 1e-4.
    """
    evaluator = KinematicsEvaluator(robot)
    q = np.array(q_start, dtype=float)
    v = np.zeros(robot.nv)
    for _ in range(iterations):
        kin = evaluator.at(q, v)
        v = solver.solve(build_hierarchy(levels, kin, t)).v
        q = pin.integrate(robot.model, q, v * step)
        if np.abs(v).max() < tolerance:
            break
    kin = evaluator.at(q, np.zeros(robot.nv))
    _require(must_hold, kin, t)
    return q


def _require(tasks: Sequence[Task], kin, t: float) -> None:
    for task in tasks:
        error = task.error(kin, t)
        worst = int(np.argmax(np.abs(error)))
        if abs(error[worst]) > 1e-4:
            raise PostureNotFoundError(
                f"no starting posture meets task {task.name!r}: {task.labels[worst]} is off by "
                f"{error[worst]:.4g} {task.units[worst]}",
                remedy="Move the first waypoint or the objects, or loosen the tasks above it",
            )
