"""A point of a frame stays inside a box, or outside a ball: velocity damping at the faces."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from equipoise.compiled import compiled, scratch
from equipoise.compiled.workspace import integers, matrix
from equipoise.errors import InputError
from equipoise.hqp import Block, Hierarchy, RowDescription
from equipoise.kinematics import Kinematics
from equipoise.kinematics.kernels import FRAMES, add_point_row, clear_row
from equipoise.kinematics.tree import FRAME_JOINT
from equipoise.spatial import Array
from equipoise.spatial.kernels import turned
from equipoise.spatial.numbers import real_number, real_vector
from equipoise.spatial.poses import rigid
from equipoise.tasks.alone import alone_of
from equipoise.tasks.base import KernelTask, require_frame, require_rate
from equipoise.tasks.view import KEEP_IN, KEEP_OUT, TaskView

POINT = 3  # numbers before those of the volume: the point in the frame [m]
_NOWHERE = 1e-9  # [m] nearer to the centre of a ball than this the way out is up


@compiled
def place_point(task: TaskView, p: np.ndarray) -> None:
    """Write where the point of the task is [3]."""
    T, n = matrix(task.state, FRAMES)[task.frame], task.numbers
    x, y, z = turned(T, n[0], n[1], n[2])
    p[0], p[1], p[2] = T[9] + x, T[10] + y, T[11] + z


@compiled
def keep_in_rows(task: TaskView) -> None:
    """Write `n . J v <= rate * (b - n . p)` for each face (n [3], b)."""
    joint, numbers, p = integers(task.tree, FRAME_JOINT)[task.frame], task.numbers, scratch(3)
    place_point(task, p)
    for k in range((numbers.shape[0] - POINT) // 4):
        face, at = numbers[POINT + 4 * k : POINT + 4 * k + 4], task.at + k
        clear_row(task.tree, joint, task.A, at)
        add_point_row(task.tree, task.state, joint, p, face, 1.0, task.A, at)
        room = face[3] - face[0] * p[0] - face[1] * p[1] - face[2] * p[2]
        task.lower[at], task.upper[at] = -np.inf, task.rate * room


@compiled
def keep_out_rows(task: TaskView) -> None:
    """Write `n . J v >= -rate * (|p - c| - r)` for the ball of centre c [3] and radius r."""
    joint, numbers, p = integers(task.tree, FRAME_JOINT)[task.frame], task.numbers, scratch(3)
    place_point(task, p)
    n, square = scratch(3), 0.0
    for i in range(3):
        n[i] = p[i] - numbers[POINT + i]
        square += n[i] * n[i]
    distance = math.sqrt(square)
    for i in range(3):
        n[i] = n[i] / distance if distance > _NOWHERE else (1.0 if i == 2 else 0.0)
    clear_row(task.tree, joint, task.A, task.at)
    add_point_row(task.tree, task.state, joint, p, n, 1.0, task.A, task.at)
    task.lower[task.at] = -task.rate * (distance - numbers[POINT + 3])
    task.upper[task.at] = np.inf


class KeepInTask(KernelTask):
    """Keep a point of a frame inside a box: `n . J v <= rate * (distance to the face)`.

    The box of `size` (3,) [m] has its middle at `T_world_box`; the point is `offset` (3,) [m] of
    `frame`. A face is approached exponentially and not crossed while `rate * dt <= 1`; from outside
    the point is led in.
    Raises: `InputError`, `NonFiniteError`, `ShapeError`.
    """

    row_unit = "m/s"
    kind = KEEP_IN
    labels = ("x+", "x-", "y+", "y-", "z+", "z-")
    units = ("m",) * 6
    alone = staticmethod(alone_of("keep_in", keep_in_rows))

    def __init__(
        self,
        name: str,
        frame: str | int,
        T_world_box: pin.SE3,
        size: Sequence[float] | Array,
        *,
        offset: Sequence[float] | Array = (0.0, 0.0, 0.0),
        rate: float = 5.0,
    ) -> None:
        super().__init__(name)
        self.frame: str | int = require_frame(name, frame)
        T = rigid(f"the box of task {name!r}", T_world_box)
        size = real_vector(f"the size of task {name!r}", size, 3)
        if not (size > 0.0).all():
            raise InputError(f"the size of task {name!r} must be positive", given=size.tolist())
        self.offset = real_vector(f"the offset of task {name!r}", offset, 3)
        self.rate = require_rate(name, rate)
        axes = np.repeat(T.rotation.T, 2, axis=0) * np.array([1.0, -1.0] * 3)[:, None]
        self.faces = np.column_stack((axes, axes @ T.translation + 0.5 * np.repeat(size, 2)))

    @property
    def numbers(self) -> Array:
        """The point, then normal and offset of each face."""
        return np.concatenate((self.offset, self.faces.ravel()))

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return how far [m] the point is beyond each face (6,)."""
        p = kin.placement(self.frame).act(self.offset)
        return np.maximum(0.0, self.faces[:, :3] @ p - self.faces[:, 3])

    def describe(self, block: Block, hierarchy: Hierarchy) -> tuple[RowDescription, ...]:
        """Return what a person calls each row."""
        return tuple(
            RowDescription.both(f"the side {label} of the box {self.name}", "m/s", self.rate)
            for label in block.labels
        )


class KeepOutTask(KernelTask):
    """Keep a point of a frame outside a ball: `n . J v >= -rate * (distance to the ball)`.

    The ball has `centre` (3,) [m] in the world and `radius` [m]; the point is `offset` (3,) [m] of
    `frame`. Whole links are kept from bodies of any shape by `AvoidanceTask`.
    Raises: `InputError`, `NonFiniteError`, `ShapeError`.
    """

    row_unit = "m/s"
    kind = KEEP_OUT
    labels = ("distance",)
    units = ("m",)
    alone = staticmethod(alone_of("keep_out", keep_out_rows))

    def __init__(
        self,
        name: str,
        frame: str | int,
        centre: Sequence[float] | Array,
        radius: float,
        *,
        offset: Sequence[float] | Array = (0.0, 0.0, 0.0),
        rate: float = 5.0,
    ) -> None:
        super().__init__(name)
        self.frame: str | int = require_frame(name, frame)
        self.centre = real_vector(f"the centre of task {name!r}", centre, 3)
        self.radius = real_number(f"the radius of task {name!r}", radius)
        if not self.radius > 0.0:
            raise InputError(f"the radius of task {name!r} must be positive", given=radius)
        self.offset = real_vector(f"the offset of task {name!r}", offset, 3)
        self.rate = require_rate(name, rate)

    @property
    def numbers(self) -> Array:
        """The point, the centre and the radius."""
        return np.concatenate((self.offset, self.centre, [self.radius]))

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return how far [m] the point is inside the ball (1,)."""
        p = kin.placement(self.frame).act(self.offset)
        return np.array([max(0.0, self.radius - float(np.linalg.norm(p - self.centre)))])

    def describe(self, block: Block, hierarchy: Hierarchy) -> tuple[RowDescription, ...]:
        """Return what a person calls the row."""
        return tuple(
            RowDescription.both(f"the distance to the ball {self.name}", "m/s", self.rate)
            for _ in block.labels
        )
