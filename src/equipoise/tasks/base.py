"""What every task provides: its rows at a state and a time, and its error in its own unit."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import Any, ClassVar

import numpy as np

from equipoise.errors import InputError
from equipoise.hqp import Block, Hierarchy, RowDescription, Rows
from equipoise.kinematics import Kinematics
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.spatial.numbers import positive
from equipoise.tasks.view import GIVEN
from equipoise.trajectories import PoseTrajectory

_ROUNDING = 1e-9  # of rate * period


class Task(ABC):
    """Produces rows `lower <= A v <= upper` for the velocity v of the robot.

    A task of your own in plain Python derives from this class; one with a kernel from
    `KernelTask`.
    """

    kind: ClassVar[int] = GIVEN

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

    @property
    def fastest_rate(self) -> float:
        """The fastest rate [1/s] with which it closes an error: its `rate`, if it has one."""
        return float(getattr(self, "rate", 0.0))

    def advice(self, robot: Robot, kin: Kinematics) -> tuple[str, ...]:
        """Return what had better be otherwise on a robot that starts at `kin`, in sentences."""
        return ()

    def describe(self, block: Block, hierarchy: Hierarchy) -> tuple[RowDescription, ...]:
        """Return what a person calls each row of the task's block in a hierarchy."""
        return tuple(
            RowDescription.both(f"{block.name}/{label}", block.unit) for label in block.labels
        )


class KernelTask(Task):
    """A task whose rows come from a kernel, `kind` telling `program` which.

    It says which `frame` (None: none) it is about, its `target`, its `rate` [1/s] and other
    `numbers`. Its rows never change in number. `alone` calls its kernel for one task, made by
    `alone_of`.
    """

    row_unit: str
    rate: float
    frame: str | int | None = None
    target: PoseTrajectory | None = None
    alone: ClassVar[Callable[..., None]]

    @property
    def numbers(self) -> Array:
        """What else the kernel needs (k,)."""
        return np.zeros(0)

    @property
    def row_labels(self) -> tuple[str, ...]:
        """Name of each row."""
        return self.labels

    def write_constants(self, A: Array, robot: Any) -> None:
        """Write what never changes in the task's rows `A` (m, nv), which are zero at first."""

    def rows(self, kin: Kinematics, t: float) -> Rows:
        """Return the rows at the state of `kin` and time `t` [s]."""
        m = len(self.row_labels)
        A, lower, upper = np.zeros((m, kin.robot.nv)), np.empty(m), np.empty(m)
        self.write_constants(A, kin.robot)
        workspace = kin.with_frames(() if self.frame is None else (self.frame,))
        target = np.zeros(18) if self.target is None else self.target.row(t)
        type(self).alone(
            workspace.floats, workspace.integers, workspace.tables, target, float(self.rate),
            self.numbers, A, lower, upper,
        )  # fmt: skip
        return Rows(self.name, self.row_unit, self.row_labels, A, lower, upper)


def describe_rows(tasks: Sequence[Task], hierarchy: Hierarchy) -> tuple[RowDescription, ...]:
    """Return what a person calls every row [m] of a hierarchy that these tasks were asked for."""
    by_name = {task.name: task for task in tasks}
    described: list[RowDescription] = []
    for block in hierarchy.blocks:
        task = by_name.get(block.name)
        plain = (RowDescription.both(f"{block.name}/{label}", block.unit) for label in block.labels)
        described += plain if task is None else task.describe(block, hierarchy)
    return tuple(described)


def by_component(task: KernelTask, block: Block) -> tuple[RowDescription, ...]:
    """Return descriptions of rows that are rates of the components of a task's error."""
    units = dict(zip(task.labels, task.units, strict=True))
    return tuple(
        RowDescription.both(task.name, f"{units[label]}/s", task.rate) for label in block.labels
    )


def require_frame(name: str, frame: str | int | None) -> str | int:
    """Return the frame of a task that needs one. Raises: `InputError`."""
    if frame is None:
        raise InputError(
            f"task {name!r} needs a frame", remedy="Give its name; `robot.frame_names` lists them"
        )
    return frame


def require_rate(name: str, rate: float) -> float:
    """Return a rate [1/s] that is finite and positive. Raises: `InputError`."""
    return positive(f"the rate of task {name!r}", rate, "1/s")


def require_rates(tasks: Sequence[Task], period: float) -> None:
    """Refuse tasks made for another period [s], or that would overshoot in one what they approach.

    A step of Euler takes `rate * period` of the way to a target or a bound: above one it goes past
    it, above two further each time, and a bound on a velocity no longer keeps a position.
    Raises: `InputError`.
    """
    for task in tasks:
        wanted = getattr(task, "period", period)
        if wanted != period:
            raise InputError(
                f"task {task.name!r} was made for another period than the generator's",
                given={"task": wanted, "generator": period},
                remedy="Give both the same [s]",
            )
        rate = task.fastest_rate
        if rate * period > 1.0 + _ROUNDING:
            raise InputError(
                f"task {task.name!r} is too fast for the period: it would go past what it "
                f"approaches, {rate:g} 1/s * {period:g} s = {rate * period:.3g} > 1",
                given={"rate": rate, "period": period},
                remedy=f"Give it a rate of at most {1.0 / period:.6g} 1/s, or a period of at most "
                f"{1.0 / rate:.6g} s",
            )
