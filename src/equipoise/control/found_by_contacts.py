"""What is lost of a state found again from the contacts that carry: the base, joints of a leg."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pinocchio as pin

from equipoise.contacts import ContactStack
from equipoise.kinematics import KinematicsEvaluator
from equipoise.robots import Robot
from equipoise.spatial import Array

STEPS = 3  # Gauss-Newton: the base moves by millimetres between two ticks
LEAST_LOAD = 1e-3  # share of all loads with which a foot in the air still counts
SEEN = 1e-6  # of a column of the contact rows, below which its joint moves no contact


class FoundByContacts:
    """Follows what is lost through the supporting contacts, slowly, from the last known place on.

    A foot that rocks on a soft floor looks like a base that moves, and a law that answers at once
    with the weight of the whole robot shakes a foot that weighs a kilogram. So feet count by the
    load that they bear, and the estimate is a low-pass of `filter_time` [s], slow for feet and fast
    for a robot that sways. It goes on with the velocity found, so that it does not trail behind
    what moves steadily.
    """

    def __init__(self, robot: Robot, dt: float, filter_time: float) -> None:
        self.robot, self._dt = robot, dt
        self.gain = 1.0 if filter_time <= 0.0 else float(-np.expm1(-dt / filter_time))
        self._kinematics = KinematicsEvaluator(robot)
        self._from: Array | None = None  # the last configuration that was known whole
        self._lost = np.zeros(robot.nv, dtype=bool)
        self._moved, self._v = np.zeros(robot.nv), np.zeros(robot.nv)
        self._loads = np.zeros(0)

    def forget(self) -> None:
        """Begin anew: everything is measured."""
        self._from = None

    def follow(
        self,
        contacts: ContactStack,
        last: tuple[Array, Array],
        measured: tuple[Array, Array],
        lost: Array,
        lam: Array,
    ) -> tuple[Array, Array] | None:
        """Return q (nq,), v (nv,) in which what is `lost` fits the rest, None if nothing holds it.

        `lost` (nv,) says what is but a first guess in `measured` q and v. `last` q and v are read
        at the first call after `forget`, or where other things are lost: where everything was, and
        how it moved. A low-pass that began at rest would stop a moving base between two ticks.
        `lam` (k,) says which feet bear how much.
        """
        model, loads = self.robot.model, loads_of(contacts, lam)
        if self._from is None or (lost != self._lost).any() or loads.shape != self._loads.shape:
            self._from, self._lost, self._loads = last[0].copy(), lost.copy(), loads
            self._moved[:], self._v[:] = 0.0, last[1]
        self._loads = self._loads + self.gain * (loads - self._loads)
        found = found_by_contacts(
            self.robot, contacts, self._from, measured, (lost, self._loads), self._kinematics
        )
        if found is None:
            return None
        apart = pin.difference(model, self._from, found[0])
        if not (np.isfinite(apart).all() and np.isfinite(found[1]).all()):
            return None
        self._moved += self._dt * self._v
        self._moved += self.gain * (apart - self._moved)
        self._v += self.gain * (found[1] - self._v)
        slow = np.where(lost, self._moved, apart)
        return pin.integrate(model, self._from, slow), np.where(lost, self._v, found[1])

    def state(self) -> dict[str, Any]:
        """Return a copy of the memory."""
        start = None if self._from is None else self._from.copy()
        kept = {"moved": self._moved, "v": self._v, "lost": self._lost, "loads": self._loads}
        return {"from": start, **{name: value.copy() for name, value in kept.items()}}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state` returned."""
        self._from = None if state["from"] is None else state["from"].copy()
        self._moved[:], self._v[:] = state["moved"], state["v"]
        self._lost[:], self._loads = state["lost"], state["loads"].copy()


def found_by_contacts(
    robot: Robot,
    contacts: ContactStack,
    last: Array,
    measured: tuple[Array, Array],
    lost: tuple[Array, Array],
    kinematics: KinematicsEvaluator,
) -> tuple[Array, Array] | None:
    """Return q (nq,) and v (nv,) that keep the supporting contacts as they were in `last` (nq,).

    `last` is known whole; `lost` says (nv,) which velocities, and their positions, of `measured`
    are but a first guess, and (n,) with which loads the supporting contacts count. Least squares
    over all their rows by load: a foot in the air says nothing, one sole of two that slips moves
    the base by half. Lost joints that move no contact stay as guessed. None if the contacts do not
    hold a lost base in all directions. The memory of `kinematics` is used again.
    """
    gone, loads = lost
    found, rates = measured[0].copy(), measured[1].copy()
    standing = ContactStack([c for c in contacts.contacts if c.supporting])
    base, where = np.flatnonzero(gone[: robot.nv_base]), np.flatnonzero(gone)
    if not len(where):
        return found, rates
    if not standing.size:
        return None
    weights = np.sqrt(np.maximum(loads, LEAST_LOAD))
    weights = np.repeat(weights, [contact.size for contact in standing.contacts])
    kept = standing.residual(kinematics.at(last))
    for _ in range(STEPS):
        kin = kinematics.at(found, rates)
        J = weights[:, None] * standing.jacobian(kin)
        if np.linalg.matrix_rank(J[:, base], tol=1e-6) < len(base):
            return None
        where = where[np.linalg.norm(J[:, where], axis=0) > SEEN]
        step = np.zeros(robot.nv)
        away = weights * (kept - standing.residual(kin))
        step[where] = np.linalg.lstsq(J[:, where], away, rcond=SEEN)[0]
        found = pin.integrate(robot.model, found, step)
    kin = kinematics.at(found, rates)
    J, wanted = weights[:, None] * standing.jacobian(kin), weights * standing.rate(kin)
    rates[where] += np.linalg.lstsq(J[:, where], wanted - J @ rates, rcond=SEEN)[0]
    return found, rates


def loads_of(contacts: ContactStack, lam: Array) -> Array:
    """Return the share (n,) of all loads that each supporting contact bears, alike if unknown."""
    loads = []
    for contact in contacts.contacts:
        if contact.supporting:
            first, normal = contacts.rows[contact.name].start, contact.normal_row
            loads.append(np.nan if normal is None else max(float(lam[first + normal]), 0.0))
    shares = np.array(loads)
    if not (np.isfinite(shares).all() and shares.sum() > 0.0):
        return np.full(len(shares), 1.0 / max(len(shares), 1))
    return shares / shares.sum()
