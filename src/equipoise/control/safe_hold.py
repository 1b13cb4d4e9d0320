"""What the joints are told in SAFE: hold the posture by a slow law, or sink slowly.

Both know the nominal robot's inertia, as the adviser does: a loop that has to stand a delay of
milliseconds needs to know how light the joints are. Neither knows its weight.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pinocchio as pin

from equipoise.contacts import ContactStack
from equipoise.contacts.pull import least_regulated
from equipoise.control.base_wrench.foot_bounds import ReactionBounds
from equipoise.control.bridging import BASE_FILTER
from equipoise.control.interface import Command, Measurement, Reference
from equipoise.control.passivity.gain_advice import (
    LONGEST_DELAY,
    advise_for_soft_floor,
    inertia_matrix,
)
from equipoise.control.passivity.gains import ControlGains
from equipoise.control.passivity.law import PassivityController
from equipoise.control.passivity.memory import STARTED
from equipoise.control.passivity.sign import SignFunction
from equipoise.robots import Robot
from equipoise.robots.dynamics import JointDynamics
from equipoise.spatial import Array

DAMPING_SHARE = 0.4  # of I / delay; the loop dv/dt = -(D/I) v(t - delay) is lost at pi/2
TOGETHER = 0.8  # the same of all joints together, in the posture of the moment
REACTION_TIME = 4.0  # of the delay: how slowly the law looks at the floor's reaction
FORCE_LAYER = 0.5  # [N] within which the force of a hand is regulated without a jump
FILTER_LAG = 0.6  # of the time constant of the filter behind which a lost base is seen
STIFFER = 3.0  # less damping carries less: kappa (alpha + kappa / 2) has to outdo gravity
STOPPING = 0.4  # [s] in which what moved comes to a stand
ROOM = 0.15  # [rad or m] that it may go on meanwhile
LEFT = 2.0  # [s] in which the torque of the moment fades: slower than the integral takes over
INTEGRAL_SLOPE = 5.0  # [rad/s^2] of the integral that carries what is not known


class SafeHold:
    """Holds a posture on the contacts of the moment with gains for a loop `delay` [s] late.

    The passivity law with `K_d = kappa M(q)`, kappa from `advise_for_soft_floor`: it starts from
    the torque of the moment, takes the weight over by its reaction and integral, and goes on
    pressing as hands did: one that lies on a wall and that the law did not know of would be driven
    along it.
    """

    def __init__(
        self,
        robot: Robot,
        contacts: ContactStack,
        dt: float,
        delay: float,
        *,
        bounds: ReactionBounds | None = None,
    ) -> None:
        self.robot, self._dt, self._delay = robot, dt, delay
        self._bounds, self._dynamics = bounds, JointDynamics(robot.model)
        self._brakes = damping_of_all(
            inertia_matrix(robot, robot.q_half_sitting), robot.nv_base, delay + 1.5 * dt
        )
        self._law = self._made(contacts)
        self._q, self._still = robot.q_half_sitting.copy(), np.zeros(robot.nv)
        self._lam_ref = np.zeros(self._law.contacts.regulated_rows.size)
        self._q_from, self._v_from = self._q, self._still
        self._began, self._stops = -np.inf, STOPPING
        self._blind, self._touching = False, frozenset(contacts.rows)

    def _made(self, contacts: ContactStack) -> PassivityController:
        return PassivityController(
            self.robot, contacts, self._gains(self.robot.q_half_sitting), self._dt,
            bounds=self._bounds, filter_time=REACTION_TIME * self._delay,
        )  # fmt: skip

    def _gains(self, q: Array, *, blind: bool = False) -> ControlGains:
        """Return the gains at q (nq,); a base that is found is seen later than one measured."""
        seen = self._delay * (1.0 + (FILTER_LAG * BASE_FILTER if blind else 0.0))
        soft = advise_for_soft_floor(
            min(max(seen, self._dt), LONGEST_DELAY), self._dt, INTEGRAL_SLOPE, projector="damping"
        )
        alpha = STIFFER * soft.alpha if blind else soft.alpha
        return ControlGains(
            K_d=soft.kappa * inertia_matrix(self.robot, q), alpha=alpha, k_ip=INTEGRAL_SLOPE,
            sgn_p=SignFunction("saturation", soft.layer),
            sgn_F=SignFunction("saturation", FORCE_LAYER), damp_violation=True,
            projector="damping", handover=LEFT,
        )  # fmt: skip

    def begin(
        self,
        t: float,
        contacts: ContactStack,
        measured: Measurement,
        tau: Array,
        *,
        blind: bool = False,
    ) -> None:
        """Come to a stand from the measured state, beginning with the torque `tau` (na,) [N m].

        What moves is stopped within `STOPPING` seconds, sooner if it would go further than `ROOM`:
        a base that is stopped at once tips over, as what stops it has to fit into the soles.
        `blind`: the base is not measured.
        """
        if contacts.contacts != self._law.contacts.contacts:
            self._law = self._made(contacts)
        self._touching = frozenset(contacts.rows)
        fastest = float(np.abs(measured.v).max(initial=0.0))
        self._began, self._stops = t, min(STOPPING, 2.0 * ROOM / max(fastest, 1e-9))
        self._q_from, self._v_from = measured.q.copy(), measured.v.copy()
        self._q = self._led(1.0)[0]
        pressed = measured.lam[contacts.regulated_rows]
        self._lam_ref = np.maximum(pressed, least_regulated(contacts.contacts))
        self._blind = blind
        self._law.gains = self._gains(self._q, blind=blind)
        self._law.reset()
        self._law.take_over(tau)

    def wanted(self, t: float) -> tuple[Array, Array]:
        """Return where the robot is led at time `t` [s], q (nq,) and v (nv,), on its way to `q`."""
        x = min(max((t - self._began) / self._stops, 0.0), 1.0)
        return self._led(x) if x < 1.0 else (self._q, self._still)

    def _led(self, x: float) -> tuple[Array, Array]:
        """Return q (nq,) and v (nv,) at a share x of the time in which it stops."""
        gone = self._stops * (x - x**3 + 0.5 * x**4)
        q = pin.integrate(self.robot.model, self._q_from, gone * self._v_from)
        return q, (1.0 - x) ** 2 * (1.0 + 2.0 * x) * self._v_from

    @property
    def q(self) -> Array:
        """The posture that is held (nq,)."""
        return self._q

    @property
    def pressed(self) -> Array:
        """What the regulated rows are held at (k,)."""
        return self._lam_ref

    def step(
        self, t: float, measured: Measurement, contacts: ContactStack, *, blind: bool = False
    ) -> Command:
        """Return the torque that holds the posture; `measured` as for a controller.

        `blind`: the base is not measured but found by the contacts. A hand that was to touch
        something later does not come there: what was not touched at the beginning is not pressed.
        """
        measured = measured._replace(lam=measured.lam[self._rows(contacts)])
        contacts = self._touched(contacts)
        if contacts.contacts != self._law.contacts.contacts:
            self.begin(t, contacts, measured, self._law.tau.copy(), blind=blind)
        elif blind != self._blind:
            self._blind = blind
            self._law.gains = self._gains(self._q, blind=blind)
            if self._law.law.flags[STARTED]:  # what is found is not quite what is measured
                self._law.take_over(self._law.tau.copy())
        return self._law.step(t, measured, Reference(*self.wanted(t), self._lam_ref))

    def _touched(self, contacts: ContactStack) -> ContactStack:
        """Return the contacts that carry, or were there when the hold began."""
        kept = [c for c in contacts.contacts if c.supporting or c.name in self._touching]
        return contacts if len(kept) == len(contacts.contacts) else ContactStack(kept)

    def _rows(self, contacts: ContactStack) -> Array:
        """Return which rows of all contacts those have."""
        touched = self._touched(contacts)
        rows = [np.arange(contacts.size)[contacts.rows[c.name]] for c in touched.contacts]
        return np.concatenate(rows) if rows else np.zeros(0, dtype=int)

    def damped(self, q: Array, rates: Array, carried: Array) -> Array:
        """Return the torque (na,) that brakes joint `rates` (na,) and still carries some weight.

        `q` (nq,) is the posture of the moment, which says how light the joints are now.
        """
        known = np.where(np.isfinite(rates), rates, 0.0)
        M, limit = self._dynamics.inertia(q), self.robot.tau_max
        if np.isfinite(M).all():
            late = self._delay + 1.5 * self._dt
            self._brakes = damping_of_all(M, self.robot.nv_base, late)
        return np.clip(carried - self._brakes * known, -limit, limit)

    def state(self) -> dict[str, Any]:
        """Return a copy of the memory."""
        return {
            "law": self._law.state(),
            "q": self._q.copy(),
            "lam_ref": self._lam_ref.copy(),
            "from": (self._q_from.copy(), self._v_from.copy()),
            "times": (self._began, self._stops),
            "blind": self._blind,
            "touching": self._touching,
        }

    def restore(self, state: Mapping[str, Any], contacts: ContactStack) -> None:
        """Continue from what `state` returned, on the contacts that hold."""
        self._touching = state["touching"]
        contacts = self._touched(contacts)
        if contacts.contacts != self._law.contacts.contacts:
            self._law = self._made(contacts)
        self._q, self._lam_ref = state["q"].copy(), state["lam_ref"].copy()
        self._q_from, self._v_from = (part.copy() for part in state["from"])
        self._began, self._stops = state["times"]
        self._blind = state["blind"]
        self._law.gains = self._gains(self._q, blind=self._blind)
        self._law.restore(state["law"])


def joint_damping(robot: Robot, q: Array, delay: float) -> Array:
    """Return the damping (na,) [N m s/rad] that each joint bears at a delay [s], all others free.

    A share of I / delay with I = 1 / (M^-1)_jj, the least inertia that the joint can meet, so that
    the same damping is stable whatever the feet touch.
    """
    least = 1.0 / np.diag(np.linalg.inv(inertia_matrix(robot, q)))
    return DAMPING_SHARE * least[robot.nv_base :] / delay


def damping_of_all(M: Array, base: int, late: float) -> Array:
    """Return the damping D (na,) [N m s/rad] that all joints together bear at inertia M (nv, nv).

    With W the joints' block of M^-1, behind `base` rows, `dv/dt = -W D v(t - late)` [s] is stable
    while the largest eigenvalue of W D is below pi / (2 late). D is in proportion to 1 / W_jj, the
    least inertia that each joint can meet, and takes `TOGETHER` of 1 / late. What contacts hold
    makes W smaller and no eigenvalue larger, so that it is stable whatever the feet touch.
    """
    W = np.linalg.inv(M)[base:, base:]
    root = 1.0 / np.sqrt(np.diag(W))
    largest = float(np.linalg.eigvalsh(root[:, None] * W * root)[-1])
    return TOGETHER / (late * largest) * root**2
