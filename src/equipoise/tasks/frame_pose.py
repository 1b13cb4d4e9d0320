"""Pose of a frame (feet, hands) follows a trajectory: six equality rows."""

from __future__ import annotations

import numpy as np

from equipoise.hqp import Rows
from equipoise.kinematics import Kinematics
from equipoise.spatial import Array, pose_error
from equipoise.tasks.base import Task
from equipoise.tasks.trajectory import PoseTrajectory


class FramePoseTask(Task):
    """Drive the pose of `frame` to a trajectory: `J v = twist_ref + rate * error`.

    Args: `rate` [1/s], the paper's alpha of task convergence.
    Source: eqs. (9)-(10). Differs from the print: the sign of (10) is that of J, the Jacobian of
    the frame itself and not of the error; the target's own twist is fed forward.
    """

    def __init__(
        self, name: str, frame_id: int, target: PoseTrajectory, *, rate: float = 10.0
    ) -> None:
        super().__init__(name)
        self.frame_id = frame_id
        self.target = target
        self.rate = rate

    labels = ("x", "y", "z", "rx", "ry", "rz")
    units = ("m", "m", "m", "rad", "rad", "rad")

    def rows(self, kin: Kinematics, t: float) -> Rows:
        """Return six equality rows in world axes."""
        sample = self.target.at(t)
        error = pose_error(sample.T_world_target, kin.placement(self.frame_id))
        wanted = sample.twist_world + self.rate * error
        J = kin.jacobian(self.frame_id)
        return Rows(self.name, "m/s, rad/s", self.labels, J, wanted, wanted)

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return (6,): position [m] and rotation vector [rad] to the target, world axes."""
        T_world_target = self.target.at(t).T_world_target
        return pose_error(T_world_target, kin.placement(self.frame_id))


def pose_error_norms(error: Array) -> tuple[float, float]:
    """Return the length [m] and the angle [rad] of a pose error (6,)."""
    return float(np.linalg.norm(error[:3])), float(np.linalg.norm(error[3:]))
