"""Offline advice on joint accelerations: how fast the nominal robot can change its velocities."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from equipoise.errors import InputError
from equipoise.robots import Robot
from equipoise.robots.dynamics import JointDynamics
from equipoise.spatial import Array
from equipoise.spatial.numbers import positive, real_vector
from equipoise.spatial.numbers import share as fraction


@dataclass(frozen=True)
class AccelerationAdvice:
    """Bounds on the joint accelerations and what they come from, by joint (na,).

    `bound` [rad/s^2]; `by_torque`, what torque is left for over the inertia, and `by_rise`, the
    speed limit over the rise time: the smaller one counts, times `share`. `inertia` [kg m^2].
    """

    bound: Array
    by_torque: Array
    by_rise: Array
    inertia: Array
    share: float
    names: tuple[str, ...]

    def sentences(self) -> tuple[str, ...]:
        """Return the advice in words, one sentence a line."""
        least, most = int(np.argmin(self.bound)), int(np.argmax(self.bound))
        torque = int(np.count_nonzero(self.by_torque < self.by_rise))
        return (
            f"Joint accelerations up to {100 * self.share:.0f} % of what the robot can: from "
            f"{self.bound[least]:.2g} rad/s^2 ({self.names[least]}) to {self.bound[most]:.2g} "
            f"rad/s^2 ({self.names[most]}).",
            f"The torque decides at {torque} joints, the rise time at {len(self.bound) - torque}.",
        )


def advise_accelerations(
    robot: Robot, q_0: Array, *, share: float = 0.5, rise: float = 0.05, speed: float = np.inf
) -> AccelerationAdvice:
    """Find once, offline, how fast the joints of the nominal robot at `q_0` (nq,) may speed up.

    `share min((tau_max - |tau_hold|) / I, min(v_max, speed) / rise)`: tau_hold holds the robot
    still on its soles; I is the largest of the joint's inertia with the base free and that with
    either sole fixed, by which ankles move the whole robot; `rise` [s] is how long the way to full
    speed takes at least. A wrist weighs so little that torque alone would allow 10^4 rad/s^2.
    Joints that turn faster than `speed` [rad/s] are treated as if they did not.
    Source: Featherstone 2008, section 6 (inertia seen by a joint); constants, so that bounds stay
    linear in v. Differs from the print: nominal model, once, as the gains.
    Raises: `InputError` where a joint cannot even hold the robot still.
    """
    fraction("share", share)
    positive("rise", rise, "s")
    if speed != np.inf:
        positive("speed", speed, "rad/s")
    q_0, base = real_vector("q_0", q_0, robot.nq), robot.nv_base
    dynamics = JointDynamics(robot.model)
    M, hold = dynamics.inertia(q_0), dynamics.gravity(q_0)
    soles = _soles(robot, q_0)
    inertia = _borne(robot, M, soles)
    if soles:
        J = np.vstack(soles)
        hold = hold - J.T @ (np.linalg.pinv(J[:, :base].T) @ hold[:base])
    left = robot.tau_max - np.abs(hold[base:])
    if not (left > 0.0).all():
        worst = int(np.argmin(left))
        raise InputError(
            f"{robot.joint_names[worst]} cannot hold the robot still: it would need "
            f"{abs(hold[base + worst]):.3g} of {robot.tau_max[worst]:.3g} N m",
            remedy="Start from another posture, or check the torque limits",
        )
    by_torque, by_rise = left / inertia, np.minimum(robot.v_max, speed) / rise
    bound = share * np.minimum(by_torque, by_rise)
    return AccelerationAdvice(bound, by_torque, by_rise, inertia, share, robot.joint_names)


def borne_inertia(robot: Robot, q_0: Array) -> Array:
    """Return the inertia (na,) [kg m^2] that each joint moves at `q_0` (nq,) at most.

    The largest of that with the base free and that with either sole fixed: an ankle moves the whole
    robot.
    """
    q_0 = real_vector("q_0", q_0, robot.nq)
    return _borne(robot, JointDynamics(robot.model).inertia(q_0), _soles(robot, q_0))


def _soles(robot: Robot, q_0: Array) -> list[Array]:
    kin = robot.at(q_0)
    return [kin.jacobian(sole.frame) for sole in robot.soles] if robot.nv_base == 6 else []


def _borne(robot: Robot, M: Array, soles: list[Array]) -> Array:
    base = robot.nv_base
    inertia = np.diag(M)[base:].copy()
    for J in soles:
        T = np.vstack((-np.linalg.solve(J[:, :base], J[:, base:]), np.eye(robot.na)))
        inertia = np.maximum(inertia, np.einsum("ij,ik,kj->j", T, M, T))
    return inertia
