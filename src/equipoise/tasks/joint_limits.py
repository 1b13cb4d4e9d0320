"""Joint position and velocity limits as bounds on the joint velocities: one row a joint."""

from __future__ import annotations

import numpy as np

from equipoise.compiled.compilation import compiled
from equipoise.kinematics import Kinematics
from equipoise.kinematics.kernels import joint_rows
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.tasks.base import KernelTask


class JointLimitsTask(KernelTask):
    """Bound each joint velocity by the velocity limit and by the room to the position limits.

    `rate * (q_min + margin - q) <= v <= rate * (q_max - margin - q)`: a limit moved in by
    `margin` [rad] is approached exponentially and not crossed while `rate * dt <= 1`.
    `velocity_share` in (0, 1] is the part of the velocity limit that may be used.
    """

    row_unit = "rad/s"
    kernel = "joint_limits"

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
        """Lower and upper positions, and the speeds, of all joints."""
        return np.concatenate((self.q_low, self.q_high, self.v_share))

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return how far [rad] each joint is beyond its limits moved in by the margin."""
        q = kin.q[7:]
        return np.maximum(0.0, np.maximum(self.q_low - q, q - self.q_high))


@compiled
def limit_rows(
    q: np.ndarray,
    limits: np.ndarray,
    rate: float,
    A: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    at: int,
) -> None:
    """Write the bounds of each joint's velocity; `limits` as `JointLimitsTask.numbers`."""
    na = limits.shape[0] // 3
    joint_rows(A, at, na)
    for i in range(na):
        v_max = limits[2 * na + i]
        lower[at + i] = min(max(rate * (limits[i] - q[7 + i]), -v_max), v_max)
        upper[at + i] = min(max(rate * (limits[na + i] - q[7 + i]), -v_max), v_max)
