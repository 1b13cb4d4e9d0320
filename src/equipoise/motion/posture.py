"""A posture that meets a hierarchy of tasks: the hierarchy followed until it rests."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from equipoise.errors import InputError
from equipoise.hqp import HierarchySolver
from equipoise.kinematics import Kinematics
from equipoise.motion.generator import MotionGenerator
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.tasks import Task

_MOST_STEPS = 3000
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
    motion = MotionGenerator(robot, levels, solver, step, q_from, t_start=t_from)
    for k in range(_MOST_STEPS):
        t = min(0.0, t_from + k * step)
        v = motion.step(t).v_ref
        if t == 0.0 and np.abs(v).max() < tolerance:
            break
    q = motion.q_ref
    _require(must_hold, robot.at(q))
    return q


def _require(tasks: Sequence[Task], kin: Kinematics) -> None:
    for task in tasks:
        error = np.abs(task.error(kin, 0.0))
        worst = int(np.argmax(error))
        if error[worst] > _MUST_BE_BELOW:
            raise PostureNotFoundError(
                f"no starting posture meets task {task.name!r}: {task.labels[worst]} is off by "
                f"{error[worst]:.4g} {task.units[worst]}",
                remedy="Move the first waypoint or the objects, or loosen the tasks above it",
            )
