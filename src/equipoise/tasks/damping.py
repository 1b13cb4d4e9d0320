"""Move as little as possible: what no task above asks for stands still, one row a velocity."""

from __future__ import annotations

from typing import Any

import numpy as np

from equipoise.compiled import compiled
from equipoise.given import require_kind
from equipoise.hqp import Block, Hierarchy, RowDescription
from equipoise.kinematics import Kinematics
from equipoise.robots import Robot, require_robot
from equipoise.spatial import Array
from equipoise.tasks.alone import alone_of
from equipoise.tasks.base import KernelTask
from equipoise.tasks.view import DAMPING, TaskView


@compiled
def damping_rows(task: TaskView) -> None:
    """Write `v_j = 0` for as many rows as the only number says."""
    for i in range(int(task.numbers[0])):
        task.lower[task.at + i] = task.upper[task.at + i] = 0.0


class DampingTask(KernelTask):
    """Ask every joint to stand still, and the base with `base`; for the end of a hierarchy.

    Without a posture below it the robot keeps the posture that it has come to.
    """

    row_unit = "rad/s"
    kind = DAMPING
    constant_rows = True
    rate = 1.0
    alone = staticmethod(alone_of("damping", damping_rows))

    def __init__(self, name: str, robot: Robot, *, base: bool = False) -> None:
        super().__init__(name)
        require_robot(f"the robot of task {name!r}", robot)
        require_kind(f"whether task {name!r} damps the base", base, bool)
        self._first = 0 if base else robot.nv_base
        self._labels = robot.velocity_names[self._first :]

    @property
    def labels(self) -> tuple[str, ...]:
        """The velocities."""
        return self._labels

    @property
    def units(self) -> tuple[str, ...]:
        """Radians a second (metres for what slides)."""
        return ("rad/s",) * len(self._labels)

    @property
    def numbers(self) -> Array:
        """How many rows."""
        return np.array([float(len(self._labels))])

    def write_constants(self, A: Array, robot: Any) -> None:
        """Write the velocities themselves."""
        A[:, self._first :] = np.eye(len(self._labels))

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return the velocities (k,)."""
        return np.array(kin.v[self._first :])

    def describe(self, block: Block, hierarchy: Hierarchy) -> tuple[RowDescription, ...]:
        """Return what a person calls each row."""
        return tuple(RowDescription.both(f"the rest of {label}", "rad/s") for label in block.labels)
