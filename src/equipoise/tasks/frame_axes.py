"""Some axes of a frame's pose follow a target: position only, one direction free, a point of it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from equipoise.compiled import compiled, scratch
from equipoise.compiled.workspace import integers, matrix
from equipoise.errors import InputError, NameNotFoundError
from equipoise.given import names_of
from equipoise.hqp import Block, Hierarchy, RowDescription
from equipoise.kinematics import Kinematics
from equipoise.kinematics.kernels import COLUMNS, FRAMES, add_point_row, clear_row
from equipoise.kinematics.tree import CHAIN, CHAIN_COLUMN, CHAIN_COUNT, CHAIN_FIRST, FRAME_JOINT
from equipoise.spatial import Array
from equipoise.spatial.kernels import rotation_difference, turned
from equipoise.spatial.numbers import real_vector
from equipoise.tasks.alone import alone_of
from equipoise.tasks.base import AimedTask, by_component, require_frame, require_rate
from equipoise.tasks.view import FRAME_AXES, TaskView
from equipoise.trajectories import PoseTrajectory

AXES = ("x", "y", "z", "rx", "ry", "rz")
OFFSET = 3  # numbers before those of the axes: a point of the frame [m]


@compiled
def frame_axes_rows(task: TaskView) -> None:
    """Write a row an axis: velocity, or angular velocity, along an axis of the target."""
    T, target, numbers, A = (
        matrix(task.state, FRAMES)[task.frame],
        task.target,
        task.numbers,
        task.A,
    )
    joint = integers(task.tree, FRAME_JOINT)[task.frame]
    columns, chain = matrix(task.state, COLUMNS), integers(task.tree, CHAIN)
    by, first = integers(task.tree, CHAIN_COLUMN), integers(task.tree, CHAIN_FIRST)[joint]
    last = first + integers(task.tree, CHAIN_COUNT)[joint]
    p, apart = scratch(3), scratch(6)
    x, y, z = turned(T, numbers[0], numbers[1], numbers[2])
    p[0], p[1], p[2] = T[9] + x, T[10] + y, T[11] + z
    for i in range(3):
        apart[i] = target[9 + i] - p[i]
    apart[3], apart[4], apart[5] = rotation_difference(target, T)
    for k in range(numbers.shape[0] - OFFSET):
        which, at = int(numbers[OFFSET + k]), task.at + k
        n = target[3 * (which % 3) : 3 * (which % 3) + 3]  # the axis itself
        half = 3 if which >= 3 else 0
        clear_row(task.tree, joint, A, at)
        if half == 0:
            add_point_row(task.tree, task.state, joint, p, n, 1.0, A, at)
        else:
            for c in range(first, last):
                w = columns[by[c], 3:6]
                A[at, chain[c]] = n[0] * w[0] + n[1] * w[1] + n[2] * w[2]
        wanted = 0.0
        for i in range(3):
            wanted += n[i] * (target[12 + half + i] + task.rate * apart[half + i])
        task.lower[at] = task.upper[at] = wanted


class FrameAxesTask(AimedTask):
    """Drive chosen `axes` of a frame's pose to a target, and leave the others free.

    `axes` are of "x", "y", "z", "rx", "ry", "rz", along and about the axes of the target: with the
    first three it is position only. `offset` (3,) [m] in the frame is the point that goes there.
    `target` is a trajectory, or a pose that may be set while it runs; `rate` [1/s].
    Source: eqs. (9)-(10), rows of it.
    Raises: `InputError`, `NameNotFoundError`, `ShapeError`.
    """

    row_unit = "m/s, rad/s"
    kind = FRAME_AXES
    alone = staticmethod(alone_of("frame_axes", frame_axes_rows))

    def __init__(
        self,
        name: str,
        frame: str | int,
        target: PoseTrajectory | pin.SE3,
        *,
        axes: Sequence[str] = AXES[:3],
        offset: Sequence[float] | Array = (0.0, 0.0, 0.0),
        rate: float = 10.0,
    ) -> None:
        super().__init__(name, target)
        self.frame: str | int = require_frame(name, frame)
        self.axes = require_axes(name, axes, AXES)
        self.offset = real_vector(f"the offset of task {name!r}", offset, 3)
        self.rate = require_rate(name, rate)

    @property
    def labels(self) -> tuple[str, ...]:
        """The axes that are driven."""
        return self.axes

    @property
    def units(self) -> tuple[str, ...]:
        """Metres along an axis, radians about it."""
        return tuple("rad" if axis.startswith("r") else "m" for axis in self.axes)

    @property
    def numbers(self) -> Array:
        """The offset, and which axes."""
        return np.array([*self.offset, *map(AXES.index, self.axes)])

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return how far it is to the target along, or about, each axis (k,) [m or rad]."""
        T, wanted = kin.placement(self.frame), self.target.at(t).T_world_target
        apart = wanted.translation - T.act(self.offset)
        turn = pin.log3(wanted.rotation @ T.rotation.T)
        both = np.concatenate((wanted.rotation.T @ apart, wanted.rotation.T @ turn))
        return both[[AXES.index(axis) for axis in self.axes]]

    def describe(self, block: Block, hierarchy: Hierarchy) -> tuple[RowDescription, ...]:
        """Return what a person calls each row."""
        return by_component(self, block)


def require_axes(name: str, axes: Sequence[str], known: Sequence[str]) -> tuple[str, ...]:
    """Return the axes of a task, each once; "xz" is short for ("x", "z").

    Raises: `InputError`, `NameNotFoundError`.
    """
    letters = tuple(axes) if isinstance(axes, str) else axes
    given = names_of(f"the axes of task {name!r}", letters)
    for axis in given:
        if axis not in known:
            raise NameNotFoundError(f"axis of task {name!r} named", axis, known)
    if not given or len(set(given)) != len(given):
        raise InputError(
            f"task {name!r} needs axes, each once", given=given, known=known, remedy="Name some"
        )
    return given
