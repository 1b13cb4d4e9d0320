"""Joint position and velocity limits as bounds on the joint velocities: one row a joint."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from equipoise.compiled import compiled
from equipoise.given import mapping_of, names_of
from equipoise.hqp import Block, Hierarchy, RowDescription
from equipoise.hqp.row_names import SPEED_LIMIT
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.spatial.numbers import not_negative
from equipoise.tasks.alone import alone_of
from equipoise.tasks.base import require_rate
from equipoise.tasks.joint_rows import JointBoundsTask
from equipoise.tasks.view import JOINT_LIMITS, TaskView, joint_positions


@compiled
def limit_rows(task: TaskView) -> None:
    """Write the bounds of each joint's velocity; the numbers are `JointLimitsTask.numbers`."""
    numbers, na = task.numbers, task.numbers.shape[0] // 3
    q = joint_positions(task.state, na)
    for i in range(na):
        angle, v_max = q[i], numbers[2 * na + i]
        low, high = task.rate * (numbers[i] - angle), task.rate * (numbers[na + i] - angle)
        task.lower[task.at + i] = min(max(low, -v_max), v_max)
        task.upper[task.at + i] = min(max(high, -v_max), v_max)


class JointLimitsTask(JointBoundsTask):
    """Bound each joint velocity by the velocity limit and by the margin to the position limits.

    `rate * (q_min + margin - q) <= v <= rate * (q_max - margin - q)`: a limit moved in by
    `margin` [rad] is approached exponentially and not crossed while `rate * dt <= 1`.
    `velocity_share` in (0, 1] is the part of the velocity limit that may be used; `speeds` [rad/s]
    bound single joints further, by name. Joints that are `frozen` do not move at all.
    Raises: `InputError` for a negative margin or speed, or a share outside (0, 1];
    `NameNotFoundError`.
    """

    row_unit = "rad/s"
    kind = JOINT_LIMITS
    constant_rows = True
    alone = staticmethod(alone_of("limit", limit_rows))

    def __init__(
        self,
        name: str,
        robot: Robot,
        *,
        margin: float = 0.01,
        velocity_share: float = 0.95,
        rate: float = 20.0,
        speeds: Mapping[str, float] | None = None,
        frozen: Sequence[str] = (),
    ) -> None:
        super().__init__(name, robot, margin, velocity_share)
        self.rate = require_rate(name, rate)
        for joint, speed in mapping_of(f"the speeds of task {name!r}", speeds).items():
            i = robot.joint_index(joint)
            speed = not_negative(f"the speed of {joint} in task {name!r}", speed, "rad/s")
            self.v_share[i] = min(self.v_share[i], speed)
        still = names_of(f"the joints that task {name!r} freezes", frozen)
        self.v_share[[robot.joint_index(joint) for joint in still]] = 0.0

    @property
    def row_caps(self) -> Array:
        """The speeds (na,)."""
        return self.v_share

    @property
    def numbers(self) -> Array:
        """Lower and upper positions, and the speeds, of all joints."""
        return np.concatenate((self.q_low, self.q_high, self.v_share))

    def describe(self, block: Block, hierarchy: Hierarchy) -> tuple[RowDescription, ...]:
        """Return what a person calls each row: a limit of position, or of speed if it is closer."""
        described = []
        ends = (hierarchy.upper[block.rows], hierarchy.lower[block.rows])
        for joint, upper, lower, speed in zip(block.labels, *ends, self.v_share, strict=True):
            above, rate_above = self._limit("upper", joint, upper, speed)
            below, rate_below = self._limit("lower", joint, lower, speed)
            described.append(RowDescription("rad/s", above, below, rate_above, rate_below))
        return tuple(described)

    def _limit(self, side: str, joint: str, bound: float, speed: float) -> tuple[str, float]:
        if abs(bound) >= speed:
            return f"{SPEED_LIMIT} {joint}", math.nan
        return f"the {side} limit of {joint}", self.rate
