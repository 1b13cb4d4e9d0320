"""The base found again from the joints and the contacts that carry it, when its sensor is lost."""

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


class BaseFromContacts:
    """Follows the base through the supporting contacts, slowly, from the last known place on.

    A foot that rocks on a soft floor looks like a base that moves, and a law that answers at once
    with the weight of the whole robot shakes a foot that weighs a kilogram. So the estimate is a
    low-pass of `filter_time` [s], slow for feet and fast for a robot that sways.
    """

    def __init__(self, robot: Robot, dt: float, filter_time: float) -> None:
        self.robot = robot
        self.gain = 1.0 if filter_time <= 0.0 else float(-np.expm1(-dt / filter_time))
        self._kinematics = KinematicsEvaluator(robot)
        self._from: Array | None = None  # the last configuration that was known whole
        self._moved, self._v = np.zeros(robot.nv_base), np.zeros(robot.nv_base)

    def forget(self) -> None:
        """Begin anew: the base is measured."""
        self._from = None

    def follow(
        self, contacts: ContactStack, last: tuple[Array, Array], q: Array, v: Array
    ) -> tuple[Array, Array] | None:
        """Return q (nq,), v (nv,) with a base that fits their joints, None if nothing holds it.

        `last` q and v are read at the first call after `forget`: where everything was, and how it
        moved. A low-pass that began at rest would stop a moving base between two ticks.
        """
        robot, base = self.robot, self.robot.nv_base
        if self._from is None:
            self._from = last[0].copy()
            self._moved[:], self._v[:] = 0.0, last[1][:base]
        found = base_from_contacts(self.robot, contacts, self._from, (q, v), self._kinematics)
        if found is None:
            return None
        apart = pin.difference(robot.model, self._from, found[0])[:base]
        if not (np.isfinite(apart).all() and np.isfinite(found[1]).all()):
            return None
        self._moved += self.gain * (apart - self._moved)
        self._v += self.gain * (found[1][:base] - self._v)
        step = np.zeros(robot.nv)
        step[:base] = self._moved
        slow_q, slow_v = pin.integrate(robot.model, self._from, step), found[1]
        slow_q[robot.nq_base :], slow_v[:base] = found[0][robot.nq_base :], self._v
        return slow_q, slow_v

    def state(self) -> dict[str, Any]:
        """Return a copy of the memory."""
        start = None if self._from is None else self._from.copy()
        return {"from": start, "moved": self._moved.copy(), "v": self._v.copy()}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state` returned."""
        self._from = None if state["from"] is None else state["from"].copy()
        self._moved[:], self._v[:] = state["moved"], state["v"]


def base_from_contacts(
    robot: Robot,
    contacts: ContactStack,
    last: Array,
    measured: tuple[Array, Array],
    kinematics: KinematicsEvaluator | None = None,
) -> tuple[Array, Array] | None:
    """Return q (nq,) and v (nv,) whose base keeps the supporting contacts as they were in `last`.

    `last` (nq,) is a configuration that is known whole; of `measured` q and v the joints count,
    their base is not read. None if the contacts do not hold the base in all directions. Least
    squares over all supporting rows, so that one sole of two that slips moves the base by half.
    `kinematics` are those of the robot, whose memory is then used again.
    """
    (q, v), kinematics = measured, kinematics or KinematicsEvaluator(robot)
    standing = ContactStack([c for c in contacts.contacts if c.supporting])
    base, nq = robot.nv_base, robot.nq_base
    if base == 0:
        return q, v
    if not standing.size:
        return None
    kept = standing.residual(kinematics.at(last))
    found, rates = q.copy(), v.copy()
    found[:nq], rates[:base] = last[:nq], 0.0
    for _ in range(STEPS):
        kin = kinematics.at(found, rates)
        J = standing.jacobian(kin)
        if np.linalg.matrix_rank(J[:, :base], tol=1e-6) < base:
            return None
        step = np.zeros(robot.nv)
        step[:base] = np.linalg.lstsq(J[:, :base], kept - standing.residual(kin), rcond=None)[0]
        found = pin.integrate(robot.model, found, step)
    kin = kinematics.at(found, rates)
    J, wanted = standing.jacobian(kin), standing.rate(kin)
    rates[:base] = np.linalg.lstsq(J[:, :base], wanted - J[:, base:] @ rates[base:], rcond=None)[0]
    return found, rates
