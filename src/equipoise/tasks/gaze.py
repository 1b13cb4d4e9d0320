"""Look at a point: the optical axis of the camera goes through it, two equality rows."""

from __future__ import annotations

import math

import numpy as np

from equipoise.compiled import compiled, entrance, scratch, scratch_matrix
from equipoise.compiled.workspace import integers, matrix
from equipoise.hqp import Block, Hierarchy, RowDescription
from equipoise.kinematics import Kinematics
from equipoise.kinematics.kernels import FRAMES, add_point_row, clear_row
from equipoise.kinematics.tree import FRAME_JOINT
from equipoise.spatial import Array, pose_row
from equipoise.spatial.kernels import turned, turned_back
from equipoise.tasks.alone import alone_of
from equipoise.tasks.base import KernelTask, by_component, require_rate
from equipoise.tasks.view import GAZE, TaskView
from equipoise.trajectories import PoseTrajectory

_NEAREST = 1e-3  # [m] a point closer to the camera than this has no direction


@compiled
def gaze_rows(task: TaskView) -> None:
    """Write the rates of (d_y, d_z) of a camera.

    A body point that now lies at the target moves, seen from the camera, against the target: so
    the rows are minus its speed along the two directions across the ray, over the distance.
    """
    T, target, A, at = matrix(task.state, FRAMES)[task.frame], task.target, task.A, task.at
    joint = integers(task.tree, FRAME_JOINT)[task.frame]
    ray, across = scratch(3), scratch_matrix(2, 3)
    distance = look(T, target, ray)
    left, up = angles(ray)
    for k in range(2):
        x, y, z = -ray[k + 1] * ray[0], -ray[k + 1] * ray[1], -ray[k + 1] * ray[2]
        if k == 0:
            y += 1.0
        else:
            z += 1.0
        x, y, z = turned(T, x / distance, y / distance, z / distance)
        across[k, 0], across[k, 1], across[k, 2] = x, y, z
        clear_row(task.tree, joint, A, at + k)
        add_point_row(task.tree, task.state, joint, target[9:12], across[k], -1.0, A, at + k)
        fed = x * target[12] + y * target[13] + z * target[14]
        task.lower[at + k] = -task.rate * (left if k == 0 else up) - fed
        task.upper[at + k] = task.lower[at + k]


@compiled
def look(T: np.ndarray, target: np.ndarray, ray: np.ndarray) -> float:
    """Write the direction to the target in camera axes; return its distance."""
    x, y, z = turned_back(T, target[9] - T[9], target[10] - T[10], target[11] - T[11])
    distance = max(math.sqrt(x * x + y * y + z * z), _NEAREST)
    ray[0], ray[1], ray[2] = x / distance, y / distance, z / distance
    return distance


@compiled
def angles(direction: np.ndarray) -> tuple[float, float]:
    """Return the angle between a direction and the x axis, split along y and z."""
    sine = math.sqrt(direction[1] ** 2 + direction[2] ** 2)
    if sine < 1e-9:
        if direction[0] < 0.0:
            return math.pi, 0.0
        return direction[1], direction[2]
    stretch = math.atan2(sine, direction[0]) / sine
    return direction[1] * stretch, direction[2] * stretch


@entrance
def gaze_error(T: np.ndarray, target: np.ndarray) -> tuple[float, float]:
    """Return the angle to the target, split into left and up, of a camera at T."""
    ray = scratch(3)
    look(T, target, ray)
    return angles(ray)


class GazeTask(KernelTask):
    """Turn the x axis of the camera frame to the origin of a moving target.

    The direction d of the target in camera axes is (1, 0, 0) when looked at; the error is the
    angle to it, along (d_y, d_z). Near the goal the rows are the exact rate of (d_y, d_z); far
    from it the error keeps the size of the angle, so that a target behind is turned to as well.
    """

    labels = ("left", "up")
    units = ("rad", "rad")
    row_unit = "rad/s"
    kind = GAZE
    alone = staticmethod(alone_of("gaze", gaze_rows))

    def __init__(
        self, name: str, camera: str | int, target: PoseTrajectory, *, rate: float = 5.0
    ) -> None:
        super().__init__(name)
        self.frame: str | int = camera
        self.target: PoseTrajectory = target
        self.rate = require_rate(name, rate)

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return the angle [rad] to the target, split into left and up (2,)."""
        return np.array(gaze_error(pose_row(kin.placement(self.frame)), self.target.row(t)))

    def describe(self, block: Block, hierarchy: Hierarchy) -> tuple[RowDescription, ...]:
        """Return what a person calls each row."""
        return by_component(self, block)
