"""A moving (rheonomic) contact: a point of the robot slides on a surface that moves by itself."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from equipoise.contacts.base import Contact
from equipoise.contacts.body_point import (
    ORIGIN,
    point_drift,
    point_jacobian,
    point_position,
    require_offset,
)
from equipoise.contacts.surfaces import Surface
from equipoise.errors import InputError
from equipoise.kinematics import Kinematics
from equipoise.spatial import Array


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

    `travel(t)` returns distance [m], speed [m/s] and acceleration [m/s^2] at time t [s].
    """

    T_world_start: pin.SE3
    direction_world: tuple[float, float, float]
    travel: Callable[[float], tuple[float, float, float]]

    def __post_init__(self) -> None:
        length = float(np.linalg.norm(self.direction_world))
        if len(self.direction_world) != 3 or not np.isclose(length, 1.0):
            raise InputError(
                "direction_world must be a unit vector (3,)", given=self.direction_world
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


@dataclass(frozen=True, kw_only=True)
class MovingSurfaceContact(Contact):
    """The point `offset` [m] of frame `frame_id` stays on a surface that moves as `motion` says.

    `phi(x, t) = 0`, so the rows are `J v = rate` with `rate = -dphi/dt / |grad phi|`: the speed
    along the normal of the place of the surface that is touched. The time is that of the
    kinematics. The row is normalised as in `SurfaceContact`.
    Source: eqs. (7), (13). Differs from the print: (13) knows no time; (7) has `nu_c` for it.
    """

    frame_id: int
    surface: Surface
    motion: SurfaceMotion
    offset: tuple[float, float, float] = ORIGIN

    def __post_init__(self) -> None:
        super().__post_init__()
        require_offset(self.name, self.offset)

    @property
    def labels(self) -> tuple[str, ...]:
        """Name of the multiplier."""
        return ("fn",)

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of the multiplier."""
        return ("N",)

    def position(self, kin: Kinematics) -> Array:
        """Return where the contact point is in the world (3,) [m]."""
        return point_position(kin, self.frame_id, self.offset)

    def normal(self, kin: Kinematics) -> Array:
        """Return the unit normal (3,) in world axes, out of the object toward the robot."""
        T = self.motion.at(kin.t).T_world_surface
        return T.rotation @ self.surface.normal(T.actInv(self.position(kin)))

    def jacobian(self, kin: Kinematics) -> Array:
        """Return `J` (1, nv): speed along the normal."""
        return (self.normal(kin) @ point_jacobian(kin, self.frame_id, self.offset))[None]

    def rate(self, kin: Kinematics) -> Array:
        """Return `nu_c` (1,) [m/s]: speed along the normal of the surface where it is touched."""
        sample = self.motion.at(kin.t)
        lever = self.position(kin) - sample.T_world_surface.translation
        carried = sample.twist_world[:3] + np.cross(sample.twist_world[3:], lever)
        return np.array([self.normal(kin) @ carried])

    def drift(self, kin: Kinematics) -> Array:
        """Return `d(J v - rate)/dt` (1,) at zero `dv/dt`, as seen from the turning surface.

        Relative acceleration along the normal, with the Coriolis and centrifugal terms of the
        surface's axes, and the normal turning as the point moves over the surface.
        """
        sample = self.motion.at(kin.t)
        T = sample.T_world_surface
        lever = self.position(kin) - T.translation
        omega, omega_rate = sample.twist_world[3:], sample.acceleration_world[3:]
        carried = sample.twist_world[:3] + np.cross(omega, lever)
        relative = point_jacobian(kin, self.frame_id, self.offset) @ kin.v - carried
        acceleration = (
            point_drift(kin, self.frame_id, self.offset)
            - sample.acceleration_world[:3]
            - np.cross(omega_rate, lever)
            - np.cross(omega, np.cross(omega, lever))
            - 2.0 * np.cross(omega, relative)
        )
        x, seen = T.actInv(self.position(kin)), T.rotation.T @ relative
        n = self.surface.normal(x)
        bent = self.surface.hessian(x) @ seen / self.surface.steepness(x)
        along = n @ (T.rotation.T @ acceleration)
        return np.array([along + bent @ seen - (n @ bent) * (n @ seen)])

    def residual(self, kin: Kinematics) -> Array:
        """Return `phi / |grad phi|` (1,) [m]: the distance to first order, positive outside."""
        T = self.motion.at(kin.t).T_world_surface
        return np.array([self.surface.distance(T.actInv(self.position(kin)))])
