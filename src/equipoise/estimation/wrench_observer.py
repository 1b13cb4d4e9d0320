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

from equipoise.contacts import Contact, ContactStack, SoleContact
from equipoise.kinematics import Kinematics, KinematicsEvaluator
from equipoise.robots import Robot, require_robot
from equipoise.robots.dynamics import JointDynamics
from equipoise.spatial import Array
from equipoise.spatial.numbers import not_negative, positive


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
        J = np.vstack([_rows_of(contact, kin) for contact in contacts.contacts])
        return np.asarray(np.linalg.lstsq(J.T, self._r, rcond=1e-9)[0])


def _rows_of(contact: Contact, kin: Kinematics) -> Array:
    """Return the Jacobian (k, nv) of a contact; of a sole in a tenth of the time of its kernel."""
    if not isinstance(contact, SoleContact):
        return contact.jacobian(kin)
    turned = contact.T_world_anchor.rotation.T
    J = kin.jacobian(contact.sole.frame)
    return np.vstack((turned @ J[:3], turned @ J[3:]))
