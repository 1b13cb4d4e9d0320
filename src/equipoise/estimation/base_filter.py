"""Pose and twist of the base from an inertial unit and from legs that stand: a Kalman filter.

The state is an element of the group of rotation, velocity, position and places of the feet, with
the biases of the unit beside it; its error is right-invariant, so that what the legs measure is
linear in it whatever the state. Source: Hartley, Ghaffari, Eustice and Grizzle, "Contact-aided
invariant extended Kalman filtering for robot state estimation", IJRR 39(4), 2020, sections 3 to 5.
Differs from the print: soles lie flat, so their orientation is measured too, against that of their
anchors; the yaw is then observable.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from equipoise.contacts import SoleContact
from equipoise.errors import InputError
from equipoise.estimation.kernels import correct, error_rate, look, move, predict
from equipoise.estimation.placed_frames import PlacedFrames
from equipoise.given import require_kind
from equipoise.robots import Robot, require_robot
from equipoise.spatial import Array, pose_row
from equipoise.spatial.numbers import positive

R_, P_ = slice(0, 3), slice(6, 9)  # of the error; velocity is between, feet and biases follow
SURE = 1e-6  # variance of what is known at the start, SI units
AT_ORIGIN = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])  # pose of the base as a quaternion
NOISE = ("rate", "acceleration", "rate_bias", "acceleration_bias", "slip", "place", "angle")


@dataclass(frozen=True)
class FilterNoise:
    """Standard deviations.

    `rate` [rad/s/sqrt(Hz)], `acceleration` [m/s^2/sqrt(Hz)] of the inertial unit, `rate_bias`
    [rad/s^2/sqrt(Hz)] and `acceleration_bias` [m/s^3/sqrt(Hz)] of the walk of its biases, `slip`
    [m/s/sqrt(Hz)] of a foot that stands; `place` [m] and `angle` [rad] of a foot from the base, by
    the joints.
    """

    rate: float = 2e-3
    acceleration: float = 3e-2
    rate_bias: float = 1e-5
    acceleration_bias: float = 1e-4
    slip: float = 1e-4
    place: float = 1e-3
    angle: float = 2e-3

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            positive(name, value)


class BaseFilter:
    """Estimates the base of a robot that stands on `soles`, all of which carry.

    Begins at rest, where the soles are at their anchors. The inertial unit is at the origin of the
    base. `variance` (n, n) is that of the error: rotation, velocity, position, feet, biases of rate
    and acceleration, in world axes. Raises: `InputError` for a robot that does not stand so.
    """

    def __init__(
        self, robot: Robot, soles: Sequence[SoleContact], noise: FilterNoise | None = None
    ) -> None:
        require_robot("the robot whose base is estimated", robot)
        soles = tuple(soles) if isinstance(soles, Sequence) else ()
        for sole in soles:
            require_kind("each foot of the filter", sole, SoleContact)
        if noise is not None:
            require_kind("the noise of the filter", noise, FilterNoise)
        if robot.nv_base != 6 or not soles:
            raise InputError(
                f"the base of {robot.name} cannot be estimated here",
                remedy="It needs a floating base that stands on soles",
            )
        self.robot, self.soles, self.noise = robot, soles, noise or FilterNoise()
        self._legs = PlacedFrames(robot, [sole.sole.frame for sole in soles])
        n = 15 + 3 * len(self.soles)
        self._anchors = [sole.T_world_anchor for sole in self.soles]
        self._anchor_rows = np.array([pose_row(anchor)[:9] for anchor in self._anchors])
        places = np.concatenate([T.translation for T in self._anchors])
        self._x = np.concatenate((np.eye(3).ravel(), np.zeros(6), places, np.zeros(6)))
        self._numbers = np.array([getattr(self.noise, name) for name in NOISE])
        self.variance: Array = SURE * np.eye(n)
        self._begun = False

    @property
    def R(self) -> Array:
        """Rotation (3, 3) of the base."""
        return self._x[:9].reshape(3, 3)

    @property
    def v(self) -> Array:
        """Velocity (3,) [m/s] of its origin, world axes."""
        return self._x[9:12]

    @property
    def p(self) -> Array:
        """Place (3,) [m] of its origin."""
        return self._x[12:15]

    @property
    def feet(self) -> Array:
        """Places (l, 3) [m] of the feet."""
        return self._x[15:-6].reshape(-1, 3)

    @property
    def rate_bias(self) -> Array:
        """What the unit shows too much (3,) [rad/s]."""
        return self._x[-6:-3]

    @property
    def acceleration_bias(self) -> Array:
        """What the unit shows too much (3,) [m/s^2]."""
        return self._x[-3:]

    def step(self, dt: float, joints: Array, imu: Array) -> tuple[Array, Array]:
        """Take in what is measured `dt` [s] after the last time; return base pose (7,), twist (6,).

        `joints` (na,); `imu` (10,) as in a `RobotState`. The pose is position and quaternion x, y,
        z, w; the twist is in base axes.
        """
        seen = self._placements(joints)
        if not self._begun:
            self._begin(seen)
        if dt > 0.0:
            predict(self._x, self.variance, imu[4:], dt, self._numbers)
        correct(self._x, self.variance, seen, self._anchor_rows, self._numbers)
        pose, twist = np.empty(7), np.empty(6)
        pose[:3], pose[3:] = self.p, pin.Quaternion(self.R).coeffs()
        twist[:3], twist[3:] = self.R.T @ self.v, imu[4:7] - self.rate_bias
        return pose, twist

    @property
    def spread(self) -> Array:
        """Standard deviations (3,): of position [m], velocity [m/s] and angle [rad]."""
        spread: Array = np.sqrt(self.variance.diagonal()[:9].reshape(3, 3).sum(axis=1)[[2, 1, 0]])
        return spread

    def _placements(self, joints: Array) -> Array:
        """Return where the soles are, seen from the base, as pose rows (l, 12)."""
        return self._legs.at(np.concatenate((AT_ORIGIN, joints)))

    def _begin(self, seen: Array) -> None:
        """Put the base where the soles say, on average."""
        found = [
            anchor * pin.SE3(row[:9].reshape(3, 3).T, row[9:]).inverse()
            for anchor, row in zip(self._anchors, seen, strict=True)
        ]
        first = found[0]
        turns = [pin.log3(first.rotation.T @ one.rotation) for one in found]
        self.R[:] = first.rotation @ pin.exp3(np.mean(turns, axis=0))
        self.p[:] = np.mean([one.translation for one in found], axis=0)
        self._begun = True

    def transition(self, dt: float) -> Array:
        """Return how the error moves on within `dt` [s] (n, n): `I + dt A`, `d xi/dt = A xi`."""
        A = np.empty_like(self.variance)
        error_rate(self._x, A)
        return np.eye(len(A)) + dt * A

    def seen(self, joints: Array) -> tuple[Array, Array]:
        """Return by how much what the joints say differs from the state, and its matrix H.

        The first (6 l,) is `H xi` of the error, by foot its place [m] and its turn [rad].
        """
        n, count = len(self.variance), len(self.soles)
        z, H = np.zeros(6 * count), np.zeros((6 * count, n))
        look(self._x, self._placements(joints), self._anchor_rows, z)
        for k in range(count):
            at, turn = slice(6 * k, 6 * k + 3), slice(6 * k + 3, 6 * k + 6)
            H[at, P_], H[at, 9 + 3 * k : 12 + 3 * k] = np.eye(3), -np.eye(3)
            H[turn, R_] = np.eye(3)
        return z, H

    def move(self, xi: Array) -> None:
        """Multiply the state from the left by the exponential of an error (n,)."""
        move(self._x, np.ascontiguousarray(xi, dtype=float))
