"""What every task provides: its rows at a state and a time, and its error in its own unit."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from equipoise.hqp import Rows
from equipoise.kinematics import Kinematics
from equipoise.spatial import Array
from equipoise.trajectories.poses import PoseTrajectory


class Task(ABC):
    """Produces rows `lower <= A v <= upper` for the velocity v of the robot.

    A task is immutable; its targets are trajectories given at construction. A task of your own in
    plain Python derives from this class; one with a kernel from `CompiledTask`.
    """

    def __init__(self, name: str) -> None:
        self.name = name

    @abstractmethod
    def rows(self, kin: Kinematics, t: float) -> Rows:
        """Return the rows at the state of `kin` and time `t` [s]."""

    @abstractmethod
    def error(self, kin: Kinematics, t: float) -> Array:
        """Return how far the task is from being met, in its own unit; positive part = violation.

        For an equality the signed error; for an inequality `max(0, violation)`.
        """

    @property
    @abstractmethod
    def labels(self) -> tuple[str, ...]:
        """Name of each component of `error`."""

    @property
    @abstractmethod
    def units(self) -> tuple[str, ...]:
        """Unit of each component of `error`."""


class CompiledTask(Task):
    """A task that writes its rows straight into the hierarchy's memory, by kernels."""

    row_unit: str

    def row_labels(self, t: float) -> tuple[str, ...]:
        """Return the name of each row at time `t` [s]; the same object while nothing changes."""
        return self.labels

    @abstractmethod
    def fill(
        self, kin: Kinematics, t: float, A: Array, lower: Array, upper: Array, at: int
    ) -> None:
        """Write `len(row_labels(t))` rows, every entry of them, from row `at` on."""

    def rows(self, kin: Kinematics, t: float) -> Rows:
        """Return the rows at the state of `kin` and time `t` [s]."""
        labels = self.row_labels(t)
        m = len(labels)
        A, lower, upper = np.empty((m, kin.robot.nv)), np.empty(m), np.empty(m)
        self.fill(kin, t, A, lower, upper, 0)
        return Rows(self.name, self.row_unit, labels, A, lower, upper)


class KernelTask(CompiledTask):
    """A task whose rows come from a kernel, together with those of others (`TaskProgram`).

    It says which `kernel`, and what that needs: a `frame`, a `rate` [1/s], a `target`, `numbers`.
    """

    kernel: str
    rate: float
    frame: int = 0
    target: PoseTrajectory | None = None

    @property
    def numbers(self) -> Array:
        """What else the kernel needs, one after the other."""
        return np.zeros(0)

    def fill(
        self, kin: Kinematics, t: float, A: Array, lower: Array, upper: Array, at: int
    ) -> None:
        """Write the rows from row `at` on."""
        from equipoise.tasks.program import TaskProgram  # it knows all kinds of tasks

        TaskProgram([self], [at]).fill(kin, t, A, lower, upper)
