"""A moving (rheonomic) contact: a point of the robot slides on a surface that moves by itself."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from equipoise.compiled import compiled
from equipoise.contacts.sliding import SlidingContact
from equipoise.errors import InputError
from equipoise.spatial import Array, pose_row
from equipoise.spatial.poses import rigid, unit_vector
from equipoise.trajectories.travel import Travel, travelled


@dataclass(frozen=True)
class MotionSample:
    """Where a surface is and how it moves.

    `twist_world` (6,): velocity of its origin [m/s], angular velocity [rad/s]; and
    `acceleration_world` (6,) their time derivatives. All in world axes.
    """

    T_world_surface: pin.SE3
    twist_world: Array
    acceleration_world: Array


class SurfaceMotion(ABC):
    """A rigid motion as a function of time."""

    @abstractmethod
    def at(self, t: float) -> MotionSample:
        """Return the motion at time `t` [s]."""


@dataclass(frozen=True)
class StraightMotion(SurfaceMotion):
    """From `T_world_start` along `direction_world` (3,), without turning.

    `travel(t)` returns distance [m], speed [m/s] and acceleration [m/s^2] at time t [s]; a `Travel`
    is evaluated by a kernel, any other function from Python.
    """

    T_world_start: pin.SE3
    direction_world: tuple[float, float, float]
    travel: Travel | Callable[[float], tuple[float, float, float]]

    def __post_init__(self) -> None:
        rigid("the start of a StraightMotion", self.T_world_start)
        unit_vector("direction_world", self.direction_world)
        if not callable(self.travel):
            raise InputError(
                "the travel of a StraightMotion must be a Travel or a function of time",
                given=self.travel,
            )

    def at(self, t: float) -> MotionSample:
        """Return the motion at time `t` [s]."""
        direction = np.asarray(self.direction_world)
        distance, speed, acceleration = self.travel(t)
        T = pin.SE3(
            self.T_world_start.rotation, self.T_world_start.translation + distance * direction
        )
        still = np.zeros(3)
        return MotionSample(
            T,
            np.concatenate((speed * direction, still)),
            np.concatenate((acceleration * direction, still)),
        )

    @property
    def numbers(self) -> Array | None:
        """What `straight_place` needs (18,): start, direction, travel; None if Python is asked."""
        if not isinstance(self.travel, Travel):
            return None
        start = pose_row(self.T_world_start)
        return np.concatenate((start, self.direction_world, self.travel.numbers))


@compiled
def straight_place(numbers: np.ndarray, t: float, place: np.ndarray) -> None:
    """Write pose row, twist and its rate [24] of a motion; see `StraightMotion.numbers`."""
    way, speed, acceleration = travelled(numbers[15:18], t)
    for i in range(12):
        place[i], place[12 + i] = numbers[i], 0.0
    for i in range(3):
        along = numbers[12 + i]
        place[9 + i] += way * along
        place[12 + i], place[18 + i] = speed * along, acceleration * along


@dataclass(frozen=True, kw_only=True)
class MovingSurfaceContact(SlidingContact):
    """The point `offset` [m] of `frame` stays on a surface that moves as `motion` says.

    `phi(x, t) = 0`, so the rows are `J v = rate` with `rate = -dphi/dt / |grad phi|`: the speed
    along the normal of the place of the surface that is touched. The time is that of the
    kinematics. Row and multiplier as in `SlidingContact`.
    Source: eqs. (7), (13). Differs from the print: (13) knows no time; (7) has `nu_c` for it.
    """

    motion: SurfaceMotion

    def place(self, t: float) -> Array:
        """Return where the surface is and how it moves at time `t` [s] (24,), in world axes."""
        sample = self.motion.at(t)
        return np.concatenate(
            (pose_row(sample.T_world_surface), sample.twist_world, sample.acceleration_world)
        )
