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
from equipoise.estimation.kernels import least_wrenches
from equipoise.estimation.placed_frames import PlacedFrames
from equipoise.kinematics import Kinematics
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
        self._rows: WrenchRows | None = None
        self._r: Array | None = None
        self._rest = np.zeros(robot.nv)  # p(0) and the integral

    def begin(self, contacts: ContactStack, q: Array, v: Array, tau: Array, t: float) -> None:
        """Begin with a robot that may move: its contacts hold, and `tau` (na,) [N m] acts.

        Gauss' principle: of all forces of the contacts those without which their rows would not
        stay as they are.
        """
        kin, M = self.robot.at(q, v, t), self._dynamics.inertia(q)
        applied = np.concatenate((np.zeros(self.robot.nv_base), tau))
        J = contacts.jacobian(kin)
        free = np.linalg.solve(M, np.column_stack((applied - self._dynamics.bias(q, v), J.T)))
        # rows may say the same, as those of hands and feet that hold one body: the least of them
        missing = J @ free[:, 0] + contacts.drift(kin)
        lam = -np.linalg.lstsq(J @ free[:, 1:], missing, rcond=1e-9)[0]
        self._begin(J.T @ lam, M @ v)

    def _begin(self, r: Array, momentum: Array) -> None:
        self._r, self._rest = r, momentum - self._time * r

    def step(self, dt: float, q: Array, v: Array, tau: Array) -> Array:
        """Return the generalised force (nv,) of the contacts.

        `q` (nq,) and `v` (nv,) now; `tau` (na,) [N m] has acted in the `dt` [s] before. At the
        first time, unless it was begun, the robot is taken to be at rest.
        """
        dynamics, robot = self._dynamics, self.robot
        M, g = dynamics.inertia(q), dynamics.gravity(q)
        applied = np.concatenate((np.zeros(robot.nv_base), tau))
        if self._r is None:
            self._begin(g - applied, M @ v)
            return self.force
        C = dynamics.coriolis(q, v)
        self._rest += dt * (applied + C.T @ v - g)
        share = dt / self._time  # the r inside of the integral, taken at the end of the step
        self._r = ((M @ v - self._rest) / self._time) / (1.0 + share)
        self._rest += dt * self._r
        return self.force

    @property
    def force(self) -> Array:
        """The generalised force (nv,) of the last step, zero before the first."""
        return np.zeros(self.robot.nv) if self._r is None else self._r.copy()

    def multipliers(self, contacts: ContactStack, q: Array, t: float) -> Array:
        """Return the multipliers (k,) of the contacts that hold, from the last step."""
        if self._r is None or not contacts.size:
            return np.zeros(contacts.size)
        if self._rows is None or self._rows.contacts is not contacts:
            self._rows = WrenchRows(self.robot, contacts)
        return self._rows.multipliers(self._r, q, t)


class WrenchRows:
    """Rows of all that the contacts of a stack may do, and what of it are their multipliers.

    A palm that rubs has forces across its normal and moments too: left out, others would be taken
    for what they do. A grasp has besides what both hands carry together. So all rows of the
    frames of a contact count; of a contact of another kind those of its own.
    """

    def __init__(self, robot: Robot, contacts: ContactStack) -> None:
        self.contacts = contacts
        frames = [frames_of(one) for one in contacts.contacts]
        sizes = [6 * len(of) or one.size for of, one in zip(frames, contacts.contacts, strict=True)]
        self._count = 6 * sum(map(len, frames))
        more = sum(sizes) - self._count
        self._placed = PlacedFrames(robot, [f for of in frames for f in of], more, rows=True)
        # those of frames come first, whatever the order of contacts
        self._places: list[slice] = []
        first, other = 0, self._count
        for of, size in zip(frames, sizes, strict=True):
            start = first if of else other
            self._places.append(slice(start, start + size))
            first, other = (first + size, other) if of else (first, other + size)

    def at(self, q: Array, t: float) -> tuple[Array, list[Array]]:
        """Return the rows (m, nv), and by contact what of them are its multipliers (k, its m)."""
        self._placed.at(q)
        kin = self._placed.kinematics(t)
        for contact, place in zip(self.contacts.contacts, self._places, strict=True):
            if place.start >= self._count:
                self._placed.J[place] = contact.jacobian(kin)
        return self._placed.J, [own_of(contact, kin) for contact in self.contacts.contacts]

    def multipliers(self, force: Array, q: Array, t: float) -> Array:
        """Return the multipliers (k,) that explain a generalised force (nv,) at `q` (nq,)."""
        J, own = self.at(q, t)
        wrenches = np.empty(len(J))
        least_wrenches(J, force, ALIKE, wrenches)
        parts = [one @ wrenches[at] for one, at in zip(own, self._places, strict=True)]
        return np.concatenate(parts)


def frames_of(contact: Contact) -> tuple[str | int, ...]:
    """Return the frames of a contact whose wrenches make its multipliers, none of other kinds."""
    if isinstance(contact, SoleContact):
        return (contact.sole.frame,)
    if isinstance(contact, GraspContact):
        return contact.frame_a, contact.frame_b
    return (contact.frame,) if isinstance(contact, SlidingContact | PointContact) else ()


def own_of(contact: Contact, kin: Kinematics) -> Array:
    """Return what of the wrenches on its frames, in world axes, are the multipliers of a contact.

    Of a grasp it is half of what acts on b less what acts on a, both at the origin of b, in the
    axes of a.
    """
    if isinstance(contact, SoleContact):
        own = np.zeros((6, 6))
        own[:3, :3] = own[3:, 3:] = contact.T_world_anchor.rotation.T
        return own
    if isinstance(contact, PointContact):
        return np.eye(3, 6)
    if isinstance(contact, SlidingContact):
        return np.concatenate((contact.normal(kin), np.zeros(3)))[None]
    if not isinstance(contact, GraspContact):
        return np.eye(contact.size)
    T_a, T_b = kin.placement(contact.frame_a), kin.placement(contact.frame_b)
    turned, own = T_a.rotation.T, np.zeros((6, 12))
    own[:3, :3] = own[3:, 3:6] = -0.5 * turned
    own[:3, 6:9] = own[3:, 9:] = 0.5 * turned
    own[3:, :3] = -0.5 * turned @ skew(T_a.translation - T_b.translation)
    return own
