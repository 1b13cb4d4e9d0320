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
from equipoise.spatial.numbers import require_period
from equipoise.tasks import Task

_LONGEST = 60.0  # [s] after which a posture that still moves is given up
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
    `step` [s] is one Euler step, shortened where a task is too fast for it. A posture that never
    comes to rest is refused.
    Returns: the configuration (nq,).
    Raises: `PostureNotFoundError` if a task of `must_hold` is violated at the end, or if the robot
    still moves.
    """
    fastest = max((task.fastest_rate for level in levels for task in level), default=0.0)
    step = require_period(step) if fastest == 0.0 else min(require_period(step), 1.0 / fastest)
    motion = MotionGenerator(robot, levels, solver, step, q_from, t_start=t_from, advise=False)
    seconds = _LONGEST - min(t_from, 0.0)
    for k in range(int(np.ceil(seconds / step))):
        t = min(0.0, t_from + k * step)
        v = motion.step(t).v_ref
        if t == 0.0 and np.abs(v).max() < tolerance:
            break
    q = motion.q_ref
    _require(must_hold, robot.at(q))
    if np.abs(v).max() >= tolerance:
        _refuse_unrest(robot, v, seconds)
    return q


def _refuse_unrest(robot: Robot, v: Array, seconds: float) -> None:
    worst = int(np.argmax(np.abs(v)))
    raise PostureNotFoundError(
        f"no starting posture: after {seconds:.0f} s {robot.velocity_names[worst]} still moves "
        f"with {v[worst]:.3g} {'m/s' if worst < 3 and robot.nv_base else 'rad/s'}",
        remedy="Move the first waypoint to where it can be reached, or loosen tasks that want "
        "different things",
    )


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
