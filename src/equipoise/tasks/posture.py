"""Posture: every joint is drawn to a configuration; one equality row a joint, the last level."""

from __future__ import annotations

import numpy as np

from equipoise.compiled.compilation import compiled
from equipoise.errors import ShapeError
from equipoise.kinematics import Kinematics
from equipoise.kinematics.kernels import joint_rows
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.tasks.base import KernelTask


class PostureTask(KernelTask):
    """Draw the joints to `q_joints` (na,) with `rate` [1/s]: `v_j = rate * (q_joints - q)_j`."""

    row_unit = "rad/s"
    kernel = "posture"

    def __init__(self, name: str, robot: Robot, q_joints: Array, *, rate: float = 1.0) -> None:
        super().__init__(name)
        if q_joints.shape != (robot.na,):
            raise ShapeError("posture target", q_joints.shape, (robot.na,))
        self.labels_ = robot.joint_names
        self.q_joints = q_joints.copy()
        self.rate = rate

    @property
    def labels(self) -> tuple[str, ...]:
        """The joint names."""
        return self.labels_

    @property
    def units(self) -> tuple[str, ...]:
        """Radians (metres for a prismatic joint)."""
        return ("rad",) * len(self.labels_)

    @property
    def numbers(self) -> Array:
        """The wanted joint positions."""
        return self.q_joints

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return (na,) [rad]: the way to the posture."""
        return self.q_joints - kin.q[7:]


@compiled
def posture_rows(
    q: np.ndarray,
    q_joints: np.ndarray,
    rate: float,
    A: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    at: int,
) -> None:
    """Write `v_j = rate * (q_joints - q)_j` for each joint."""
    joint_rows(A, at, len(q_joints))
    for i in range(len(q_joints)):
        lower[at + i] = rate * (q_joints[i] - q[7 + i])
        upper[at + i] = lower[at + i]
