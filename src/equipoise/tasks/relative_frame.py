"""The pose of one frame as another one sees it: two hands that keep together wherever they go."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from equipoise.compiled import compiled, scratch
from equipoise.compiled.workspace import Block, integers, matrix
from equipoise.errors import InputError
from equipoise.hqp import Block as RowBlock
from equipoise.hqp import Hierarchy, RowDescription
from equipoise.kinematics import Kinematics
from equipoise.kinematics.kernels import COLUMNS, FRAMES, add_point_row, clear_row
from equipoise.kinematics.tree import CHAIN, CHAIN_COLUMN, CHAIN_COUNT, CHAIN_FIRST, FRAME_JOINT
from equipoise.spatial import Array
from equipoise.spatial.kernels import compose, rotation_difference
from equipoise.tasks.alone import alone_of
from equipoise.tasks.base import AimedTask, by_component, require_frame, require_rate
from equipoise.tasks.frame_axes import AXES, require_axes
from equipoise.tasks.view import RELATIVE_FRAME, TaskView
from equipoise.trajectories import PoseTrajectory


@compiled
def relative_frame_rows(task: TaskView) -> None:
    """Write a row an axis of the other frame; `numbers` are which that is, and the axes."""
    T, numbers, A = matrix(task.state, FRAMES)[task.frame], task.numbers, task.A
    other = int(numbers[0])
    seen_from, target, there = matrix(task.state, FRAMES)[other], task.target, scratch(12)
    joint = integers(task.tree, FRAME_JOINT)[task.frame]
    carrier = integers(task.tree, FRAME_JOINT)[other]
    compose(seen_from, target[:12], there)
    apart = scratch(6)
    for i in range(3):
        apart[i] = there[9 + i] - T[9 + i]
    apart[3], apart[4], apart[5] = rotation_difference(there, T)
    p = T[9:12]
    for k in range(numbers.shape[0] - 1):
        which, at = int(numbers[1 + k]), task.at + k
        n = seen_from[3 * (which % 3) : 3 * (which % 3) + 3]  # the axis itself
        half = 3 if which >= 3 else 0
        clear_row(task.tree, carrier, A, at)
        clear_row(task.tree, joint, A, at)
        if half == 0:
            add_point_row(task.tree, task.state, joint, p, n, 1.0, A, at)
            add_point_row(task.tree, task.state, carrier, p, n, -1.0, A, at)
        else:
            add_turning_row(task.tree, task.state, joint, n, 1.0, A, at)
            add_turning_row(task.tree, task.state, carrier, n, -1.0, A, at)
        wanted = target[12 + which]
        for i in range(3):
            wanted += task.rate * n[i] * apart[half + i]
        task.lower[at] = task.upper[at] = wanted


@compiled
def add_turning_row(
    tree: Block, state: Block, joint: int, n: np.ndarray, sign: float, A: np.ndarray, at: int
) -> None:
    """Add to A[at] the angular velocity about `sign` n [3] of a joint's body."""
    columns, chain = matrix(state, COLUMNS), integers(tree, CHAIN)
    by, first = integers(tree, CHAIN_COLUMN), integers(tree, CHAIN_FIRST)[joint]
    for k in range(first, first + integers(tree, CHAIN_COUNT)[joint]):
        w = columns[by[k], 3:6]
        A[at, chain[k]] += sign * (n[0] * w[0] + n[1] * w[1] + n[2] * w[2])


class RelativeFrameTask(AimedTask):
    """Drive the pose of `frame`, as the frame `relative_to` sees it, to a target.

    Target, twist and `axes` ("x" to "rz", all by default) are in the axes of `relative_to`. The
    target is a trajectory, or a pose that may be set while it runs; `rate` [1/s].
    Source: eqs. (9)-(10), for the difference of two frames.
    Raises: `InputError`, `NameNotFoundError`.
    """

    row_unit = "m/s, rad/s"
    kind = RELATIVE_FRAME
    alone = staticmethod(alone_of("relative_frame", relative_frame_rows))

    def __init__(
        self,
        name: str,
        frame: str | int,
        relative_to: str | int,
        target: PoseTrajectory | pin.SE3,
        *,
        axes: Sequence[str] = AXES,
        rate: float = 10.0,
    ) -> None:
        super().__init__(name, target)
        self.frame: str | int = require_frame(name, frame)
        self.second: str | int = require_frame(name, relative_to)
        if self.frame == self.second:
            raise InputError(f"task {name!r} needs two frames", given=(frame, relative_to))
        self.axes = require_axes(name, axes, AXES)
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
        """The number of the other frame, 1 where the task stands alone, and which axes."""
        return np.array([1.0, *map(AXES.index, self.axes)])

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return how far it is to the target along, or about, each axis (k,) [m or rad]."""
        here = kin.placement(self.second).inverse() * kin.placement(self.frame)
        wanted = self.target.at(t).T_world_target
        turn = pin.log3(wanted.rotation @ here.rotation.T)
        both = np.concatenate((wanted.translation - here.translation, turn))
        return both[[AXES.index(axis) for axis in self.axes]]

    def describe(self, block: RowBlock, hierarchy: Hierarchy) -> tuple[RowDescription, ...]:
        """Return what a person calls each row."""
        return by_component(self, block)
