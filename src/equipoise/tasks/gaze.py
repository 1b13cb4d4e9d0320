"""Look at a point: the optical axis of the camera goes through it, two equality rows."""

from __future__ import annotations

import numpy as np

from equipoise.hqp import Rows
from equipoise.kinematics import Kinematics
from equipoise.spatial import Array, skew
from equipoise.tasks.base import Task
from equipoise.tasks.trajectory import PoseTrajectory

_NEAREST = 1e-3  # [m] a point closer to the camera than this has no direction


class GazeTask(Task):
    """Turn the x axis of the camera frame to the origin of a moving target.

    The direction d of the target in camera axes is (1, 0, 0) when looked at; the error is the
    angle to it, along (d_y, d_z). Near the goal the rows are the exact rate of (d_y, d_z); far
    from it the error keeps the size of the angle, so that a target behind is turned to as well.
    """

    labels = ("left", "up")
    units = ("rad", "rad")

    def __init__(
        self, name: str, camera_id: int, target: PoseTrajectory, *, rate: float = 5.0
    ) -> None:
        super().__init__(name)
        self.camera_id = camera_id
        self.target = target
        self.rate = rate

    def rows(self, kin: Kinematics, t: float) -> Rows:
        """Return two equality rows: rates of (d_y, d_z)."""
        sample = self.target.at(t)
        ray, R = self._ray(kin, sample.T_world_target.translation)
        distance = max(float(np.linalg.norm(ray)), _NEAREST)
        direction = ray / distance
        J = kin.jacobian(self.camera_id)
        across = (np.eye(3)[1:] - np.outer(direction[1:], direction)) / distance
        turned = across @ R.T
        A = (across @ skew(ray) @ R.T) @ J[3:] - turned @ J[:3]
        feedforward = turned @ sample.twist_world[:3]
        wanted = -self.rate * _angle_error(direction) - feedforward
        return Rows(self.name, "rad/s", self.labels, A, wanted, wanted)

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return the angle [rad] to the target, split into left and up (2,)."""
        ray, _ = self._ray(kin, self.target.at(t).T_world_target.translation)
        return _angle_error(ray / max(float(np.linalg.norm(ray)), _NEAREST))

    def _ray(self, kin: Kinematics, p_world_target: Array) -> tuple[Array, Array]:
        T_world_camera = kin.placement(self.camera_id)
        R = T_world_camera.rotation
        return R.T @ (p_world_target - T_world_camera.translation), R


def _angle_error(direction: Array) -> Array:
    sideways = direction[1:]
    sine = float(np.linalg.norm(sideways))
    if sine < 1e-9:
        behind = direction[0] < 0.0
        return np.array([np.pi, 0.0]) if behind else sideways.copy()
    return sideways * (np.arctan2(sine, direction[0]) / sine)
