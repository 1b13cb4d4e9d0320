"""Look at a point: the optical axis of the camera goes through it, two equality rows."""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin

from equipoise.compiled import compiled, entrance, scratch, scratch_matrix
from equipoise.compiled.workspace import integers, matrix
from equipoise.hqp import Block, Hierarchy, RowDescription
from equipoise.kinematics import Kinematics
from equipoise.kinematics.kernels import FRAMES, add_point_row, clear_row
from equipoise.kinematics.tree import FRAME_JOINT
from equipoise.spatial import Array, pose_row
from equipoise.spatial.kernels import turned, turned_back
from equipoise.tasks.alone import alone_of
from equipoise.tasks.base import AimedTask, by_component, require_frame, require_rate
from equipoise.tasks.view import GAZE, TaskView
from equipoise.trajectories import PoseTrajectory

_NEAREST = 1e-3  # [m] a point closer to the camera than this has no direction
_STRAIGHT = (
    1e-9  # share of the ray across the axis: below it the target is straight ahead or behind
)
_SIDEWAYS = 0.5  # share of the ray behind the camera from which on it is only turned sideways


@compiled
def gaze_rows(task: TaskView) -> None:
    """Write the rates of the target's direction, along y and z carried from the axis to it.

    A body point that now lies at the target moves, seen from the camera, against the target: so
    the rows are minus its speed along the two directions across the ray, over the distance.
    """
    T, target, A, at = matrix(task.state, FRAMES)[task.frame], task.target, task.A, task.at
    joint = integers(task.tree, FRAME_JOINT)[task.frame]
    ray, across, error = scratch(3), scratch_matrix(2, 3), scratch(2)
    distance = look(T, target, ray)
    angles(ray, across, error)
    for k in range(2):
        x, y, z = across[k, 0] / distance, across[k, 1] / distance, across[k, 2] / distance
        x, y, z = turned(T, x, y, z)
        across[k, 0], across[k, 1], across[k, 2] = x, y, z
        clear_row(task.tree, joint, A, at + k)
        add_point_row(task.tree, task.state, joint, target[9:12], across[k], -1.0, A, at + k)
        fed = x * target[12] + y * target[13] + z * target[14]
        task.lower[at + k] = -task.rate * error[k] - fed
        task.upper[at + k] = task.lower[at + k]


@compiled
def look(T: np.ndarray, target: np.ndarray, ray: np.ndarray) -> float:
    """Write the direction to the target in camera axes; return its distance."""
    x, y, z = turned_back(T, target[9] - T[9], target[10] - T[10], target[11] - T[11])
    length = math.sqrt(x * x + y * y + z * z)
    if length > 0.0:
        ray[0], ray[1], ray[2] = x / length, y / length, z / length
    else:
        ray[0], ray[1], ray[2] = 1.0, 0.0, 0.0
    return max(length, _NEAREST)


@compiled
def angles(ray: np.ndarray, across: np.ndarray, error: np.ndarray) -> None:
    """Write the angle [rad] between a direction and the x axis, split in two, and along what.

    `across` [2, 3] are y and z, carried along from x to the ray on the shortest way: unit vectors
    across the ray. `error` [2] says along them where the ray comes from: its length is the angle,
    and it points away from x, as the shortest way does; behind, where that would lead over the top
    of the head and from straight behind anywhere, it turns into the way around the z axis, to the
    left if the target is on neither side.
    """
    x, y, z = ray[0], ray[1], ray[2]
    sine = math.sqrt(y * y + z * z)
    if sine > _STRAIGHT:
        left, up = y / sine, z / sine
    else:
        left, up = 1.0, 0.0
    bent = 1.0 - x
    turned_up = -bent * left * up
    across[0, 0], across[0, 1], across[0, 2] = -sine * left, 1.0 - bent * left * left, turned_up
    across[1, 0], across[1, 1], across[1, 2] = -sine * up, turned_up, 1.0 - bent * up * up
    angle = math.atan2(sine, x)
    if sine <= _STRAIGHT and x > 0.0:
        error[0], error[1] = y, z
        return
    if x < 0.0:
        level = math.sqrt(x * x + y * y)
        if level > 0.0:
            side = -1.0 if y < -_STRAIGHT else 1.0
            ex, ey = -side * y / level, side * x / level  # away from the front, around z
            share = min(-x / _SIDEWAYS, 1.0)
            share *= share * (3.0 - 2.0 * share)
            around_left = across[0, 0] * ex + across[0, 1] * ey
            around_up = across[1, 0] * ex + across[1, 1] * ey
            left += share * (around_left - left)
            up += share * (around_up - up)
            length = math.sqrt(left * left + up * up)
            left, up = left / length, up / length
    error[0], error[1] = angle * left, angle * up


@entrance
def gaze_error(T: np.ndarray, target: np.ndarray, error: np.ndarray) -> None:
    """Write the angle to the target, split into left and up, of a camera at T."""
    ray, across = scratch(3), scratch_matrix(2, 3)
    look(T, target, ray)
    angles(ray, across, error)


class GazeTask(AimedTask):
    """Turn the x axis of the camera frame to the origin of a moving target, wherever that is.

    The rows are the rates of the target's direction in camera axes, along y and z carried from the
    optical axis to it; they ask that the angle [rad] shrinks at `rate` [1/s] on the shortest way.
    A target behind is turned to sideways, about the camera's z; one straight behind, or straight
    above and behind, to the left. That side is kept, since turning makes it the nearer one.
    Raises: `InputError`.
    """

    labels = ("left", "up")
    units = ("rad", "rad")
    row_unit = "rad/s"
    kind = GAZE
    alone = staticmethod(alone_of("gaze", gaze_rows))

    def __init__(
        self,
        name: str,
        camera: str | int,
        target: PoseTrajectory | pin.SE3,
        *,
        rate: float = 5.0,
    ) -> None:
        super().__init__(name, target)
        self.frame: str | int = require_frame(name, camera)
        self.rate = require_rate(name, rate)

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return the angle [rad] to the target, split into left and up (2,)."""
        error = np.empty(2)
        gaze_error(pose_row(kin.placement(self.frame)), self.target.row(t), error)
        return error

    def describe(self, block: Block, hierarchy: Hierarchy) -> tuple[RowDescription, ...]:
        """Return what a person calls each row."""
        return by_component(self, block)
