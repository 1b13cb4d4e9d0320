"""Posture: every joint is drawn to a configuration; one equality row a joint, the last level."""

from __future__ import annotations

import numpy as np

from equipoise.errors import ShapeError
from equipoise.hqp import Rows
from equipoise.kinematics import Kinematics
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.tasks.base import Task


class PostureTask(Task):
    """Draw the joints to `q_joints` (na,) with `rate` [1/s]: `v_j = rate * (q_joints - q)_j`."""

    def __init__(self, name: str, robot: Robot, q_joints: Array, *, rate: float = 1.0) -> None:
        super().__init__(name)
        if q_joints.shape != (robot.na,):
            raise ShapeError("posture target", q_joints.shape, (robot.na,))
        self.labels_ = robot.joint_names
        self.q_joints = q_joints.copy()
        self.rate = rate
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
        """Return one equality row a joint."""
        wanted = self.rate * self.error(kin, t)
        return Rows(self.name, "rad/s", self.labels_, self._A, wanted, wanted)

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return (na,) [rad]: the way to the posture."""
        return self.q_joints - kin.q[7:]
