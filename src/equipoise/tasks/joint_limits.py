"""Joint position and velocity limits as bounds on the joint velocities: one row a joint."""

from __future__ import annotations

import numpy as np

from equipoise.hqp import Rows
from equipoise.kinematics import Kinematics
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.tasks.base import Task


class JointLimitsTask(Task):
    """Bound each joint velocity by the velocity limit and by the room to the position limits.

    `rate * (q_min + margin - q) <= v <= rate * (q_max - margin - q)`: a limit moved in by
    `margin` [rad] is approached exponentially and not crossed while `rate * dt <= 1`.
    `velocity_share` in (0, 1] is the part of the velocity limit that may be used.
    """

    def __init__(
        self,
        name: str,
        robot: Robot,
        *,
        margin: float = 0.01,
        velocity_share: float = 0.95,
        rate: float = 20.0,
    ) -> None:
        super().__init__(name)
        self.labels_ = robot.joint_names
        self.rate = rate
        room = 0.25 * (robot.q_max - robot.q_min)
        inset = np.minimum(margin, room)
        self.q_low = robot.q_min + inset
        self.q_high = robot.q_max - inset
        self.v_share = velocity_share * robot.v_max
        self._A = np.hstack((np.zeros((robot.na, 6)), np.eye(robot.na)))
        self._A.flags.writeable = False

    @property
    def labels(self) -> tuple[str, ...]:
        """The joint names."""
        return self.labels_

    @property
    def units(self) -> tuple[str, ...]:
        """Radians (metres for a prismatic joint)."""
        return ("rad",) * len(self.labels_)

    def rows(self, kin: Kinematics, t: float) -> Rows:
        """Return one two-sided row a joint. Outside a limit the row asks to come back."""
        q = kin.q[7:]
        upper = np.clip(self.rate * (self.q_high - q), -self.v_share, self.v_share)
        lower = np.clip(self.rate * (self.q_low - q), -self.v_share, self.v_share)
        return Rows(self.name, "rad/s", self.labels_, self._A, lower, upper)

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return how far [rad] each joint is beyond its limits moved in by the margin."""
        q = kin.q[7:]
        return np.maximum(0.0, np.maximum(self.q_low - q, q - self.q_high))
