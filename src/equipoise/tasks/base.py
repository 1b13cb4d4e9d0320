"""What every task provides: its rows at a state and a time, and its error in its own unit."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, ClassVar, Self, TypeAlias

import numpy as np
import pinocchio as pin

from equipoise.errors import InputError
from equipoise.given import require_kind
from equipoise.hqp import Block, Hierarchy, RowDescription, Rows
from equipoise.kinematics import Kinematics
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.spatial.numbers import positive
from equipoise.tasks.view import GIVEN
from equipoise.trajectories import LiveTarget, PoseTrajectory
from equipoise.trajectories.base import require_trajectory

_ROUNDING = 1e-9  # of rate * period
LIGHTEST, HEAVIEST = 1e-3, 1e3  # weights


class Task(ABC):
    """Produces rows `lower <= A v <= upper` for the velocity v of the robot.

    A task of your own in plain Python derives from this class; one with a kernel from
    `KernelTask`. `weight` says how much its shortfall counts beside others of its level, `ease`
    [1/s] how fast its bounds let a velocity change, infinite where they are of first order.
    """

    kind: ClassVar[int] = GIVEN
    weight: float = 1.0
    ease: float = math.inf

    def __init__(self, name: str) -> None:
        require_kind("the name of a task", name, str)
        self.name = name

    def weighing(self, weight: float) -> Self:
        """Return this task, its shortfall counting `weight` times as much as that of others.

        A level makes the sum of squares of its shortfalls, each times its weight, as small as can
        be; where nothing is short, weights do nothing. Say it before a controller is given the
        task. What `rows` returns is as it was: who stacks levels scales them.
        Raises: `InputError`.
        """
        weight = positive(f"the weight of task {self.name!r}", weight, "")
        if not LIGHTEST <= weight <= HEAVIEST:
            raise InputError(
                f"the weight of task {self.name!r} must lie between {LIGHTEST:g} and {HEAVIEST:g}",
                given=weight,
                remedy="Put what is so much more important into a level above",
            )
        self.weight = weight
        return self

    def easing(self, ease: float) -> Self:
        """Return this task with rows of second order in the tick, so that v_ref gets no kinks.

        What is left of a bound shrinks by `ease` [1/s] at most, and a velocity that is asked for
        is come to with `ease`: see `motion.easing`. Say it before a controller is given the task.
        What `rows` returns is as it was. Raises: `InputError`.
        """
        if self.needs_before:
            raise InputError(
                f"task {self.name!r} knows the velocity of the tick before by itself: it has no "
                "ease",
                given=ease,
            )
        self.ease = positive(f"the ease of task {self.name!r}", ease, "1/s")
        return self

    @property
    def needs_before(self) -> bool:
        """Whether its rows depend on the velocity of the tick before, whatever its ease."""
        return False

    @property
    def row_caps(self) -> Array | None:
        """Where its bounds end [of A v] (m,), as speed limits do; None if nowhere."""
        return None

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
    `numbers`. With a `second` frame the first of these becomes the number of that frame. Its rows
    never change in number; with `constant_rows` A is what `write_constants` wrote. `alone` calls
    its kernel for one task, made by `alone_of`.
    """

    row_unit: str
    rate: float
    constant_rows: ClassVar[bool] = False
    frame: str | int | None = None
    second: str | int | None = None
    target: PoseTrajectory | None = None
    alone: ClassVar[Callable[..., None]]

    @property
    def numbers(self) -> Array:
        """What else the kernel needs (k,)."""
        return np.zeros(0)

    @property
    def frames(self) -> tuple[str | int, ...]:
        """The frames that it is about."""
        return tuple(one for one in (self.frame, self.second) if one is not None)

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
        workspace = kin.with_frames(self.frames)
        target = np.zeros(18) if self.target is None else self.target.row(t)
        type(self).alone(
            workspace.floats, workspace.integers, workspace.tables, target, float(self.rate),
            self.numbers, A, lower, upper,
        )  # fmt: skip
        return Rows(self.name, self.row_unit, self.row_labels, A, lower, upper)


Pose: TypeAlias = pin.SE3 | tuple[pin.SE3, Array]


class AimedTask(KernelTask):
    """A task with a target: a trajectory given at the beginning, or a pose set while it runs.

    `task.target = pose`, or `= pose, twist`, from any thread, where the target was given as a pose
    or as a `LiveTarget`; it is taken at the next tick and faded (see `LiveTarget`).
    """

    def __init__(self, name: str, target: PoseTrajectory | pin.SE3) -> None:
        super().__init__(name)
        if isinstance(target, pin.SE3):
            target = LiveTarget(target)
        require_trajectory(f"the target of task {name!r}", target)
        self._target: PoseTrajectory = target

    @property
    def target(self) -> PoseTrajectory:
        """What is followed; set it to a pose, or to a pose and its twist (6,) in world axes."""
        return self._target

    @target.setter
    def target(self, wanted: Pose) -> None:
        live = self._target
        if not isinstance(live, LiveTarget):
            raise InputError(
                f"the target of task {self.name!r} is a {type(live).__name__}, which says itself "
                "where it is",
                remedy="To set it while it runs, give the task a pose or a `LiveTarget(pose)` at "
                "its construction",
            )
        pose, twist = wanted if isinstance(wanted, tuple) else (wanted, None)
        live.set(pose, twist)


def describe_rows(
    tasks: Sequence[Task],
    hierarchy: Hierarchy,
    kin: Kinematics | None = None,
    period: float = math.inf,
) -> tuple[RowDescription, ...]:
    """Return what a person calls every row [m] of a hierarchy that these tasks were asked for.

    What has an ease needs the state `kin` of the tick, for a bound on speed to be told from one on
    a position, and the `period` of the ticks [s], by which a wish is less.
    """
    by_name = {task.name: task for task in tasks}
    described: list[RowDescription] = []
    for block in hierarchy.blocks:
        task = by_name.get(block.name)
        plain = (RowDescription.both(f"{block.name}/{label}", block.unit) for label in block.labels)
        if task is None:
            words = tuple(plain)
        elif kin is not None and math.isfinite(task.ease):
            words = _describe_eased(task, kin, min(task.ease * period, 1.0))
        else:
            words = task.describe(block, hierarchy)
        weight = 1.0 if task is None else task.weight
        described += [replace(one, weight=weight) for one in words] if weight != 1.0 else words
    return tuple(described)


def _describe_eased(task: Task, kin: Kinematics, share: float) -> tuple[RowDescription, ...]:
    """Return the words of a task's rows of first order; its wishes are less by a share."""
    first = Hierarchy.stack([[task.rows(kin, kin.t)]], kin.robot.nv)
    words = []
    for k, one in enumerate(task.describe(first.blocks[0], first)):
        less = share if first.lower[k] == first.upper[k] else 1.0
        above, below = less * one.rate_above, less * one.rate_below
        words.append(replace(one, rate_above=above, rate_below=below))
    return tuple(words)


def by_component(task: KernelTask, block: Block) -> tuple[RowDescription, ...]:
    """Return descriptions of rows that are rates of the components of a task's error."""
    units = dict(zip(task.labels, task.units, strict=True))
    return tuple(
        RowDescription.both(task.name, f"{units[label]}/s", task.rate) for label in block.labels
    )


def require_frame(name: str, frame: str | int | None) -> str | int:
    """Return the frame of a task that needs one. Raises: `InputError`."""
    if isinstance(frame, bool) or not isinstance(frame, str | int):
        raise InputError(
            f"task {name!r} needs a frame",
            given=frame,
            remedy="Give its name; `robot.frame_names` lists them",
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
