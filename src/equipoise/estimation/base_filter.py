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
from equipoise.given import require_kind
from equipoise.kinematics import KinematicsEvaluator
from equipoise.robots import Robot, require_robot
from equipoise.spatial import Array, skew
from equipoise.spatial.numbers import positive

GRAVITY = np.array([0.0, 0.0, -9.81])  # [m/s^2], world axes
R_, V_, P_ = slice(0, 3), slice(3, 6), slice(6, 9)  # of the error; the feet follow, then biases
SURE = 1e-6  # variance of what is known at the start, SI units


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
        self._kinematics = KinematicsEvaluator(robot)
        n = 15 + 3 * len(self.soles)
        self._feet = [slice(9 + 3 * k, 12 + 3 * k) for k in range(len(self.soles))]
        self._rate_bias, self._acceleration_bias = slice(n - 6, n - 3), slice(n - 3, n)
        self._anchors = [sole.T_world_anchor for sole in self.soles]
        self.R, self.v, self.p = np.eye(3), np.zeros(3), np.zeros(3)
        self.feet = [T.translation.copy() for T in self._anchors]
        self.rate_bias, self.acceleration_bias = np.zeros(3), np.zeros(3)
        self.variance: Array = SURE * np.eye(n)
        self._begun = False

    def step(self, dt: float, joints: Array, imu: Array) -> tuple[Array, Array]:
        """Take in what is measured `dt` [s] after the last time; return base pose (7,), twist (6,).

        `joints` (na,); `imu` (10,) as in a `RobotState`. The pose is position and quaternion x, y,
        z, w; the twist is in base axes.
        """
        if not self._begun:
            self._begin(joints)
        rate, felt = imu[4:7] - self.rate_bias, imu[7:10] - self.acceleration_bias
        if dt > 0.0:
            self._predict(dt, rate, felt)
        self._correct(joints)
        rate = imu[4:7] - self.rate_bias
        return pin.SE3ToXYZQUAT(pin.SE3(self.R, self.p)), np.concatenate((self.R.T @ self.v, rate))

    @property
    def spread(self) -> Array:
        """Standard deviations (3,): of position [m], velocity [m/s] and angle [rad]."""
        return np.sqrt([np.trace(self.variance[part, part]) for part in (P_, V_, R_)])

    def _placements(self, joints: Array) -> list[pin.SE3]:
        """Return where the soles are, seen from the base."""
        q = np.concatenate(([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], joints))
        kin = self._kinematics.at(q)
        return [kin.placement(sole.sole.frame) for sole in self.soles]

    def _begin(self, joints: Array) -> None:
        """Put the base where the soles say, on average."""
        found = [
            anchor * seen.inverse()
            for anchor, seen in zip(self._anchors, self._placements(joints), strict=True)
        ]
        first = found[0]
        turns = [pin.log3(first.rotation.T @ one.rotation) for one in found]
        self.R = first.rotation @ pin.exp3(np.mean(turns, axis=0))
        self.p = np.mean([one.translation for one in found], axis=0)
        self._begun = True

    def transition(self, dt: float) -> Array:
        """Return how the error moves on within `dt` [s] (n, n): `I + dt A`, `d xi/dt = A xi`."""
        n, R = len(self.variance), self.R
        A = np.zeros((n, n))
        A[V_, R_], A[P_, V_] = skew(GRAVITY), np.eye(3)
        A[R_, self._rate_bias] = -R
        A[V_, self._rate_bias], A[V_, self._acceleration_bias] = -skew(self.v) @ R, -R
        for part, place in zip((P_, *self._feet), (self.p, *self.feet), strict=True):
            A[part, self._rate_bias] = -skew(place) @ R
        return np.eye(n) + dt * A

    def _adjoint(self) -> Array:
        """Return what turns noise in base axes into an error in world axes (n, n)."""
        n, R = len(self.variance), self.R
        adjoint = np.eye(n)
        adjoint[R_, R_] = adjoint[V_, V_] = R
        adjoint[V_, R_] = skew(self.v) @ R
        for part, place in zip((P_, *self._feet), (self.p, *self.feet), strict=True):
            adjoint[part, part], adjoint[part, R_] = R, skew(place) @ R
        return adjoint

    def _predict(self, dt: float, rate: Array, felt: Array) -> None:
        """Move on by what the inertial unit felt."""
        noise, adjoint, step = self.noise, self._adjoint(), self.transition(dt)
        white = np.repeat([noise.rate, noise.acceleration, 0.0], 3)
        walks = np.repeat([noise.rate_bias, noise.acceleration_bias], 3)
        slips = np.full(3 * len(self.soles), noise.slip)
        Q = (adjoint * np.concatenate((white, slips, walks)) ** 2) @ adjoint.T
        self.variance = step @ (self.variance + dt * Q) @ step.T
        a = self.R @ felt + GRAVITY
        self.p = self.p + dt * self.v + 0.5 * dt * dt * a
        self.v = self.v + dt * a
        self.R = self.R @ pin.exp3(dt * rate)

    def seen(self, joints: Array) -> tuple[Array, Array]:
        """Return by how much what the joints say differs from the state, and its matrix H.

        The first (6 l,) is `H xi` of the error, by foot its place [m] and its turn [rad].
        """
        n, count = len(self.variance), len(self.soles)
        z, H = np.zeros(6 * count), np.zeros((6 * count, n))
        for k, sole in enumerate(self._placements(joints)):
            at, turn = slice(6 * k, 6 * k + 3), slice(6 * k + 3, 6 * k + 6)
            z[at] = self.R @ sole.translation + self.p - self.feet[k]
            H[at, P_], H[at, self._feet[k]] = np.eye(3), -np.eye(3)
            z[turn] = pin.log3(self.R @ sole.rotation @ self._anchors[k].rotation.T)
            H[turn, R_] = np.eye(3)
        return z, H

    def _correct(self, joints: Array) -> None:
        """Take in where the soles are, seen from the base, and how they are turned."""
        z, H = self.seen(joints)
        noise = np.repeat([self.noise.place, self.noise.angle], 3) ** 2
        N = np.diag(np.tile(noise, len(self.soles)))
        S = H @ self.variance @ H.T + N
        K = np.linalg.solve(S, H @ self.variance).T
        self.move(-K @ z)
        keep = np.eye(len(self.variance)) - K @ H
        self.variance = keep @ self.variance @ keep.T + K @ N @ K.T

    def move(self, xi: Array) -> None:
        """Multiply the state from the left by the exponential of an error (n,)."""
        turn, left = pin.exp3(xi[R_]), pin.Jexp3(-xi[R_])
        self.R = turn @ self.R
        self.v = turn @ self.v + left @ xi[V_]
        self.p = turn @ self.p + left @ xi[P_]
        self.feet = [
            turn @ foot + left @ xi[part] for foot, part in zip(self.feet, self._feet, strict=True)
        ]
        self.rate_bias = self.rate_bias + xi[self._rate_bias]
        self.acceleration_bias = self.acceleration_bias + xi[self._acceleration_bias]
