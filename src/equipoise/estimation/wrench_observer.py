"""What acts in the contacts, from joint torques: an observer of the generalised momentum.

It uses the nominal dynamic model: masses, inertias, gravity. The control law sees none of that,
only the multipliers that come out.
Source: De Luca, Albu-Schaffer, Haddadin and Hirzinger, "Collision detection and safe reaction with
the DLR-III lightweight manipulator arm", IROS 2006, eq. (12) to (15), with the base as six more
coordinates: with the momentum `p = M v`,
`r = K (p - integral(S' tau + C' v - g + r) - p(0))` follows the generalised force `J' lam` as a
low-pass of first order.
"""

from __future__ import annotations

import numpy as np

from equipoise.contacts import (
    Contact,
    ContactStack,
    GraspContact,
    PointContact,
    SoleContact,
)
from equipoise.contacts.sliding import SlidingContact
from equipoise.kinematics import Kinematics, KinematicsEvaluator
from equipoise.robots import Robot, require_robot
from equipoise.robots.dynamics import JointDynamics
from equipoise.spatial import Array, skew
from equipoise.spatial.numbers import not_negative, positive

ALIKE = 1e-12  # of the mean square of a row: rows that differ by less are not told apart


class WrenchObserver:
    """Estimates the multipliers of contacts of a nominal robot; late by `filter_time` [s].

    `rotor_inertia` [kg m^2] is what each joint has besides. Where contacts cannot be told apart,
    the least multipliers that explain the motion are returned.
    """

    def __init__(self, robot: Robot, filter_time: float, rotor_inertia: float = 0.0) -> None:
        require_robot("the robot that is observed", robot)
        rotor_inertia = not_negative("the rotor inertia", rotor_inertia, "kg m^2")
        self.robot, self._time = robot, positive("filter_time", filter_time, "s")
        self._model = robot.model.copy()
        armature = np.array(self._model.armature)
        armature[robot.nv_base :] += rotor_inertia
        self._model.armature = armature
        self._dynamics = JointDynamics(self._model)
        self._kinematics = KinematicsEvaluator(robot)
        self._r: Array | None = None
        self._rest = np.zeros(robot.nv)  # p(0) and the integral

    def step(self, dt: float, q: Array, v: Array, tau: Array) -> Array:
        """Return the generalised force (nv,) of the contacts.

        `q` (nq,) and `v` (nv,) now; `tau` (na,) [N m] has acted in the `dt` [s] before. At the
        first time the robot is taken to be at rest.
        """
        dynamics, robot = self._dynamics, self.robot
        M, g = dynamics.inertia(q), dynamics.gravity(q)
        applied = np.concatenate((np.zeros(robot.nv_base), tau))
        if self._r is None:
            self._r = g - applied
            self._rest = M @ v - self._time * self._r
            return self._r.copy()
        C = dynamics.coriolis(q, v)
        self._rest += dt * (applied + C.T @ v - g)
        share = dt / self._time  # the r inside of the integral, taken at the end of the step
        self._r = ((M @ v - self._rest) / self._time) / (1.0 + share)
        self._rest += dt * self._r
        return self._r.copy()

    def multipliers(self, contacts: ContactStack, q: Array, v: Array, t: float) -> Array:
        """Return the multipliers (k,) of the contacts that hold, from the last step."""
        if self._r is None or not contacts.size:
            return np.zeros(contacts.size)
        kin = self._kinematics.at(q, v, t)
        parts = [wrench_rows(contact, kin) for contact in contacts.contacts]
        J = np.vstack([rows for rows, _ in parts])
        G = J @ J.T  # in a fifth of the time of a singular value decomposition
        G[np.diag_indices_from(G)] += ALIKE * np.trace(G) / len(G)
        wrenches = np.linalg.solve(G, J @ self._r)
        ends = np.cumsum([len(rows) for rows, _ in parts])[:-1]
        return np.concatenate(
            [own @ w for (_, own), w in zip(parts, np.split(wrenches, ends), strict=True)]
        )


def wrench_rows(contact: Contact, kin: Kinematics) -> tuple[Array, Array]:
    """Return rows (m, nv) of all that a contact may do, and what of it is its multipliers (k, m).

    A palm that rubs has forces across its normal and moments too: left out, others would be taken
    for what they do. A grasp has besides what both hands carry together.
    """
    if isinstance(contact, SoleContact):  # in a tenth of the time of its kernel
        turned = contact.T_world_anchor.rotation.T
        J = kin.jacobian(contact.sole.frame)
        return np.vstack((turned @ J[:3], turned @ J[3:])), np.eye(6)
    if isinstance(contact, GraspContact):
        return _grasp_rows(contact, kin)
    J = contact.jacobian(kin)
    if not isinstance(contact, SlidingContact | PointContact):
        return J, np.eye(len(J))
    own = np.zeros((len(J), 6))
    whole = kin.jacobian(contact.frame)
    if (
        isinstance(kin.robot, Robot) and kin.robot.nv_base == 6
    ):  # a shift of the base moves all frames alike
        own[:, :3] = J[:, :3] @ whole[:3, :3].T
    else:
        own[:, :3] = np.linalg.lstsq(whole.T, J.T, rcond=None)[0][:3].T
    return whole, own


def _grasp_rows(contact: GraspContact, kin: Kinematics) -> tuple[Array, Array]:
    """Return rows (12, nv) of the wrenches on both bodies, and the grasp's own of them (6, 12).

    It is half of what acts on b less what acts on a, both at the origin of b, in the axes of a.
    """
    T_a, T_b = kin.placement(contact.frame_a), kin.placement(contact.frame_b)
    turned, own = T_a.rotation.T, np.zeros((6, 12))
    own[:3, :3] = own[3:, 3:6] = -0.5 * turned
    own[:3, 6:9] = own[3:, 9:] = 0.5 * turned
    own[3:, :3] = -0.5 * turned @ skew(T_a.translation - T_b.translation)
    return np.vstack((kin.jacobian(contact.frame_a), kin.jacobian(contact.frame_b))), own
