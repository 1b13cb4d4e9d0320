"""The centre of mass follows a point, along chosen axes: one equality row an axis."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from equipoise.compiled import compiled
from equipoise.compiled.workspace import matrix, vector
from equipoise.hqp import Block, Hierarchy, RowDescription
from equipoise.kinematics import Kinematics
from equipoise.kinematics.kernels import COM, COM_ROWS
from equipoise.spatial import Array, pose
from equipoise.tasks.alone import alone_of
from equipoise.tasks.base import AimedTask, by_component, require_rate
from equipoise.tasks.frame_axes import require_axes
from equipoise.tasks.view import COM_POINT, TaskView
from equipoise.trajectories import PoseTrajectory

AXES = ("x", "y", "z")


@compiled
def com_point_rows(task: TaskView) -> None:
    """Write `J_com v = rate_of_target + rate * (target - com)` along each axis."""
    com, J_com, target, numbers = (
        vector(task.state, COM),
        matrix(task.state, COM_ROWS),
        task.target,
        task.numbers,
    )
    for k in range(numbers.shape[0]):
        i, at = int(numbers[k]), task.at + k
        for c in range(J_com.shape[1]):
            task.A[at, c] = J_com[i, c]
        task.lower[at] = target[12 + i] + task.rate * (target[9 + i] - com[i])
        task.upper[at] = task.lower[at]


class ComTask(AimedTask):
    """Drive the nominal centre of mass to a point, along `axes` ("x", "y", "z") of the world.

    `target` is the point (3,) [m], or a pose or trajectory of which the origin counts; a point or
    a pose may be set while it runs: `task.target = pose((x, y, z))`. `rate` [1/s].
    Raises: `InputError`, `NameNotFoundError`, `ShapeError`.
    """

    row_unit = "m/s"
    kind = COM_POINT
    alone = staticmethod(alone_of("com_point", com_point_rows))

    def __init__(
        self,
        name: str,
        target: PoseTrajectory | pin.SE3 | Sequence[float] | Array,
        *,
        axes: Sequence[str] = AXES,
        rate: float = 5.0,
    ) -> None:
        aimed = target if isinstance(target, PoseTrajectory | pin.SE3) else pose(target)
        super().__init__(name, aimed)
        self.axes = require_axes(name, axes, AXES)
        self.rate = require_rate(name, rate)

    @property
    def labels(self) -> tuple[str, ...]:
        """The axes that are driven."""
        return self.axes

    @property
    def units(self) -> tuple[str, ...]:
        """Metres."""
        return ("m",) * len(self.axes)

    @property
    def numbers(self) -> Array:
        """Which axes."""
        return np.array([float(AXES.index(axis)) for axis in self.axes])

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return how far [m] it is to the point along each axis (k,)."""
        apart = self.target.at(t).T_world_target.translation - kin.p_world_com
        return np.asarray(apart)[[AXES.index(axis) for axis in self.axes]]

    def describe(self, block: Block, hierarchy: Hierarchy) -> tuple[RowDescription, ...]:
        """Return what a person calls each row."""
        return by_component(self, block)
