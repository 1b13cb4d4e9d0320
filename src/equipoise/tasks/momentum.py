"""Linear and angular momentum about the centre of mass have values: one equality row an axis."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from equipoise.compiled import compiled, scratch
from equipoise.compiled.workspace import integers, vector
from equipoise.hqp import Block, Hierarchy, RowDescription
from equipoise.kinematics import Kinematics
from equipoise.kinematics.kernels import COM
from equipoise.kinematics.momentum import momentum_column, weigh_turning
from equipoise.kinematics.tree import FIRST_COLUMN, FIRST_V, FOLLOWS, WIDTH
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.spatial.numbers import real_vector
from equipoise.tasks.alone import alone_of
from equipoise.tasks.base import KernelTask
from equipoise.tasks.frame_axes import AXES, require_axes
from equipoise.tasks.view import MOMENTUM, TaskView


@compiled
def momentum_rows(task: TaskView) -> None:
    """Write a row an axis; the numbers are axis, scale and value of each."""
    tree, A, at, numbers = task.tree, task.A, task.at, task.numbers
    first_v, first, width, follows = (
        integers(tree, FIRST_V),
        integers(tree, FIRST_COLUMN),
        integers(tree, WIDTH),
        integers(tree, FOLLOWS),
    )
    weigh_turning(tree, task.state)
    com, p, count = vector(task.state, COM), scratch(6), numbers.shape[0] // 3
    for j in range(1, first_v.shape[0]):
        for k in range(width[j]):
            momentum_column(tree, task.state, j, first[j] + k, p)
            p[3] -= com[1] * p[2] - com[2] * p[1]  # about the centre of mass
            p[4] -= com[2] * p[0] - com[0] * p[2]
            p[5] -= com[0] * p[1] - com[1] * p[0]
            c = first_v[j] + k
            for i in range(count):
                value = numbers[3 * i + 1] * p[int(numbers[3 * i])]
                A[at + i, c] = A[at + i, c] + value if follows[j] else value
    for i in range(count):
        task.lower[at + i] = task.upper[at + i] = numbers[3 * i + 1] * numbers[3 * i + 2]


class MomentumTask(KernelTask):
    """Give the nominal robot's momentum a value, along and about `axes` of the world.

    `axes` are of "x", "y", "z" [N s] and "rx", "ry", "rz" [N m s], these about the centre of mass;
    `value` (k,) is zero if left out: a robot that does not turn in the air, or about its feet. The
    rows are divided by the mass, and by the mean moment of inertia at half-sitting, so that they
    are velocities of the centre of mass and of the robot as one body.
    Source: Orin, Goswami and Lee 2013 (the centroidal momentum matrix).
    Raises: `InputError`, `NameNotFoundError`, `ShapeError`.
    """

    row_unit = "m/s, rad/s"
    kind = MOMENTUM
    rate = 1.0
    alone = staticmethod(alone_of("momentum", momentum_rows))

    def __init__(
        self,
        name: str,
        robot: Robot,
        *,
        axes: Sequence[str] = AXES[3:],
        value: Sequence[float] | Array | None = None,
    ) -> None:
        super().__init__(name)
        self.axes = require_axes(name, axes, AXES)
        wanted = np.zeros(len(self.axes)) if value is None else value
        self.value = real_vector(f"the value of task {name!r}", wanted, len(self.axes))
        turning = 3.0 / float(np.trace(_inertia(robot)))
        self.scale = np.array([turning if a.startswith("r") else 1.0 / robot.mass for a in axes])

    @property
    def labels(self) -> tuple[str, ...]:
        """The axes."""
        return self.axes

    @property
    def units(self) -> tuple[str, ...]:
        """Newton seconds along an axis, newton metre seconds about it."""
        return tuple("N m s" if axis.startswith("r") else "N s" for axis in self.axes)

    @property
    def numbers(self) -> Array:
        """Axis, scale and value of each row."""
        which = [float(AXES.index(axis)) for axis in self.axes]
        return np.column_stack((which, self.scale, self.value)).ravel()

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return what is missing to the value at the state's velocity (k,) [N s or N m s]."""
        return self.value - self.rows(kin, t).A @ kin.v / self.scale

    def describe(self, block: Block, hierarchy: Hierarchy) -> tuple[RowDescription, ...]:
        """Return what a person calls each row."""
        return tuple(
            RowDescription.both(
                f"the momentum {'about' if label.startswith('r') else 'along'} {label[-1]}",
                "rad/s" if label.startswith("r") else "m/s",
                math.nan,
            )
            for label in block.labels
        )


def _inertia(robot: Robot) -> Array:
    """Return the inertia (3, 3) [kg m^2] of the robot at half-sitting about its centre of mass."""
    kin, total = robot.at(robot.q_half_sitting), np.zeros((3, 3))
    for joint in range(1, robot.model.njoints):
        T, body = kin.joint_placement(joint), robot.model.inertias[joint]
        lever = T.act(body.lever) - kin.p_world_com
        total += T.rotation @ body.inertia @ T.rotation.T
        total += body.mass * (lever @ lever * np.eye(3) - np.outer(lever, lever))
    return total
