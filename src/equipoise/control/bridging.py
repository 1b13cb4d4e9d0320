"""Fills the holes of a measured state: velocities by difference, a base by its contacts.

For how long holes may be filled the supervisor decides.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pinocchio as pin

from equipoise.contacts import ContactStack
from equipoise.control.found_by_contacts import FoundByContacts
from equipoise.control.interface import Measurement
from equipoise.robots import Robot
from equipoise.spatial import Array

BASE_FILTER = 5.0  # of the delay: four robots stood in MuJoCo with 4 to 6, at 5 ms


class Bridge:
    """Makes a state whole that has holes, tick by tick.

    A joint whose velocity is lost is differentiated over the `delay` [s], one whose position is
    lost is integrated. Of what is lost altogether, contacts that carry tell the base and the joints
    of a leg; where they may not be asked, or do not tell, it keeps the error that it had to the
    reference, so that nobody pulls at it.
    """

    def __init__(self, robot: Robot, dt: float, delay: float) -> None:
        self.robot, self._dt = robot, dt
        self._follows = dt / (dt + delay)  # share of a tick by which a difference is followed
        self._found = FoundByContacts(robot, dt, BASE_FILTER * delay)
        self._apart: Array | None = None  # dq and dv (2, nv) when something was lost

    def forget(self) -> None:
        """Begin anew: everything is measured."""
        self._found.forget()
        self._apart = None

    def hand_over(self) -> None:
        """Note that there is another reference from now on, to which errors begin anew."""
        self._apart = None

    def fill(
        self,
        contacts: ContactStack,
        measured: Measurement,
        last: Measurement,
        reference: tuple[Array, Array],
        *,
        ask_contacts: bool,
    ) -> Measurement:
        """Return a state without holes, with the measured forces.

        `last` is the newest whole state, filled or measured; `reference` q (nq,) and v (nv,).
        """
        robot, model = self.robot, self.robot.model
        nq, nv = robot.nq_base, robot.nv_base
        q, v = np.where(np.isfinite(measured.q), measured.q, last.q), measured.v.copy()
        if robot.nq_base == 7:
            q[3:7] /= np.linalg.norm(q[3:7])
        lost_q = ~np.isfinite(measured.q[nq:])
        lost_v = ~np.isfinite(measured.v[nv:])
        if not (lost_q.any() or lost_v.any()) and np.isfinite([*measured.q, *measured.v]).all():
            self.forget()
            return Measurement(q, v, measured.lam)
        if self._apart is None:
            self._apart = np.array(
                [pin.difference(model, reference[0], last.q), last.v - reference[1]]
            )
        only_v = lost_v & ~lost_q
        if only_v.any():
            rate = (q[nq:] - last.q[nq:]) / self._dt
            slow = last.v[nv:] + self._follows * (rate - last.v[nv:])
            v[nv:][only_v] = slow[only_v]
        only_q = lost_q & ~lost_v
        q[nq:][only_q] += self._dt * v[nv:][only_q]
        gone = np.zeros(robot.nv, dtype=bool)
        gone[nv:] = lost_q & lost_v
        gone[:nv] = not np.isfinite([*measured.q[:nq], *measured.v[:nv]]).all()
        if not gone.any():
            self._found.forget()
            return Measurement(q, v, measured.lam)
        self._keep_apart(q, v, gone, reference)
        whole = Measurement(q, v, measured.lam)
        if not ask_contacts:
            self._found.forget()
            return whole
        forces = np.where(np.isfinite(measured.lam), measured.lam, 0.0)
        found = self._found.follow(contacts, (last.q, last.v), (q, v), gone, forces)
        return whole if found is None else whole._replace(q=found[0], v=found[1])

    def _keep_apart(self, q: Array, v: Array, gone: Array, reference: tuple[Array, Array]) -> None:
        """Write to q (nq,) and v (nv,) what is `gone` (nv,): the reference and the error to it."""
        assert self._apart is not None
        nq, nv = self.robot.nq_base, self.robot.nv_base
        kept_q = pin.integrate(self.robot.model, reference[0], self._apart[0])
        kept_v = reference[1] + self._apart[1]
        v[gone] = kept_v[gone]
        q[nq:] = np.where(gone[nv:], kept_q[nq:], q[nq:])
        if gone[:nv].any():
            q[:nq] = kept_q[:nq]

    def state(self) -> dict[str, Any]:
        """Return a copy of the memory."""
        apart = None if self._apart is None else self._apart.copy()
        return {"apart": apart, "found": self._found.state()}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state` returned."""
        self._apart = None if state["apart"] is None else state["apart"].copy()
        self._found.restore(state["found"])
