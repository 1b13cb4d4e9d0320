"""Tasks whose rows are the velocities of the joints, one each; and what bounds of theirs share."""

from __future__ import annotations

from typing import Any

import numpy as np

from equipoise.kinematics import Kinematics
from equipoise.robots import Robot, require_robot
from equipoise.spatial import Array
from equipoise.spatial.numbers import not_negative, share
from equipoise.tasks.base import KernelTask


def write_joint_rows(A: Array, robot: Any) -> None:
    """Write the unit rows `A` (na, nv) of the actuated joints, which follow the base."""
    for i in range(len(A)):
        A[i, robot.nv_base + i] = 1.0


class JointTask(KernelTask):
    """A row for each actuated joint."""

    def __init__(self, name: str, robot: Robot) -> None:
        super().__init__(name)
        require_robot(f"the robot of task {name!r}", robot)
        self._labels = robot.joint_names

    @property
    def labels(self) -> tuple[str, ...]:
        """The joint names."""
        return self._labels

    @property
    def units(self) -> tuple[str, ...]:
        """Radians (metres for a prismatic joint)."""
        return ("rad",) * len(self._labels)

    def write_constants(self, A: Array, robot: Any) -> None:
        """Write the velocities of the joints."""
        write_joint_rows(A, robot)


class JointBoundsTask(JointTask):
    """Joints stay inside their limits, moved in by `margin`, below a share of their speed.

    Of a joint with little room half of it is left.
    """

    def __init__(self, name: str, robot: Robot, margin: float, velocity_share: float) -> None:
        super().__init__(name, robot)
        margin = not_negative(f"the margin of task {name!r}", margin, "rad")
        velocity_share = share(f"the velocity share of task {name!r}", velocity_share)
        inset = np.minimum(margin, 0.25 * (robot.q_max - robot.q_min))
        self.q_low, self.q_high = robot.q_min + inset, robot.q_max - inset
        self.v_share = velocity_share * robot.v_max

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return how far [rad] each joint is beyond its limits moved in by the margin."""
        q = kin.q[-len(self.q_low) :]
        return np.maximum(0.0, np.maximum(self.q_low - q, q - self.q_high))
