"""A wanted pose over time: what every kind offers, and kinds that a kernel evaluates."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from equipoise.errors import InputError, NonFiniteError
from equipoise.spatial import Array, pose_row
from equipoise.spatial.numbers import real_number

# kinds of targets as kernels know them; GIVEN is written from Python
GIVEN, FIXED, WAYPOINTS, ATTACHED, TRAVEL, LIVE = range(6)
SHORTEST = 1e-4  # [s] between two moments of a way: less is a slip, and no controller follows
NEARLY = 0.999  # of it, since differences of times are rounded
ROW = 18  # numbers of a target: a pose row, then its twist


def instant(t: float) -> float:
    """Return a time [s] at which a trajectory may be asked; infinities are its ends.

    Raises: `NonFiniteError` for a NaN, `InputError` for what is no number.
    """
    at = real_number("the time", t, finite=False)
    if at != at:
        raise NonFiniteError("the time at which a trajectory is asked is NaN")
    return at


@dataclass(frozen=True)
class PoseSample:
    """A pose and its rate: `twist_world` (6,) = velocity of the origin, angular velocity."""

    T_world_target: pin.SE3
    twist_world: Array


class PoseTrajectory(ABC):
    """A pose as a smooth function of time. One of your own gives `at`; the tick then asks it."""

    kind = GIVEN

    @abstractmethod
    def at(self, t: float) -> PoseSample:
        """Return the pose and its rate at time `t` [s]."""

    def row(self, t: float) -> Array:
        """Return the same as kernels read it (18,): a pose row and the twist."""
        sample = self.at(t)
        return np.concatenate((pose_row(sample.T_world_target), sample.twist_world))


def require_trajectory(what: str, given: object) -> None:
    """Refuse what is no trajectory of poses. Raises: `InputError`."""
    if isinstance(given, PoseTrajectory):
        return
    remedy = "Give a `FixedPose`, a `WaypointTrajectory`, or a `PoseTrajectory` of your own"
    if isinstance(given, pin.SE3):
        remedy = "A pose that does not move is `FixedPose(T)`"
    raise InputError(
        f"{what} must be a trajectory of poses", given=type(given).__name__, remedy=remedy
    )


class CompiledTrajectory(PoseTrajectory):
    """A trajectory that a kernel evaluates, from `numbers` and the row of what it rides on.

    `kind` is its number in `targets`, where the kernels are called.
    """

    @property
    @abstractmethod
    def numbers(self) -> Array:
        """What the kernel needs (k,)."""

    @property
    def rides_on(self) -> PoseTrajectory | None:
        """The trajectory of the body that carries this one, if there is one."""
        return None

    @abstractmethod
    def row(self, t: float) -> Array:
        """Return pose row and twist (18,) at time `t` [s]."""

    def at(self, t: float) -> PoseSample:
        """Return the pose and its rate at time `t` [s]."""
        row = self.row(t)
        T = pin.SE3(row[:9].reshape(3, 3).T.copy(), row[9:12].copy())
        return PoseSample(T, row[12:].copy())
