"""Pose of a frame (feet, hands) follows a trajectory: six equality rows."""

from __future__ import annotations

import numpy as np

from equipoise.compiled.compilation import compiled, entrance
from equipoise.kinematics import Kinematics
from equipoise.kinematics.kernels import frame_rows
from equipoise.spatial import Array
from equipoise.spatial.kernels import rotation_difference
from equipoise.tasks.base import KernelTask
from equipoise.trajectories.poses import PoseTrajectory


class FramePoseTask(KernelTask):
    """Drive the pose of `frame` to a trajectory: `J v = twist_ref + rate * error`.

    Args: `rate` [1/s], the paper's alpha of task convergence.
    Source: eqs. (9)-(10). Differs from the print: the sign of (10) is that of J, the Jacobian of
    the frame itself and not of the error; the target's own twist is fed forward.
    """

    row_unit = "m/s, rad/s"
    kernel = "frame_pose"

    def __init__(
        self, name: str, frame_id: int, target: PoseTrajectory, *, rate: float = 10.0
    ) -> None:
        super().__init__(name)
        self.frame_id = self.frame = frame_id
        self.target = target
        self.rate = rate

    labels = ("x", "y", "z", "rx", "ry", "rz")
    units = ("m", "m", "m", "rad", "rad", "rad")

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return (6,): position [m] and rotation vector [rad] to the target, world axes."""
        error = np.empty(6)
        pose_difference(self.target.row(t), kin.live.frames[self.frame_id], error)
        return error


@compiled
def pose_task_rows(
    columns: np.ndarray,
    carried: np.ndarray,
    T: np.ndarray,
    target: np.ndarray,
    rate: float,
    A: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    at: int,
) -> None:
    """Write `J v = twist_ref + rate * error` of a frame at T; `target` [18] is pose and twist."""
    frame_rows(columns, carried, T, A, at)
    rx, ry, rz = rotation_difference(target, T)
    for i in range(3):
        lower[at + i] = target[12 + i] + rate * (target[9 + i] - T[9 + i])
    lower[at + 3] = target[15] + rate * rx
    lower[at + 4] = target[16] + rate * ry
    lower[at + 5] = target[17] + rate * rz
    for i in range(at, at + 6):
        upper[i] = lower[i]


@entrance
def pose_difference(target: np.ndarray, T: np.ndarray, error: np.ndarray) -> None:
    """Write to `error` [6] what carries the pose row T to `target`, in world axes."""
    for i in range(3):
        error[i] = target[9 + i] - T[9 + i]
    error[3], error[4], error[5] = rotation_difference(target, T)
