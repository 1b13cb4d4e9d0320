"""What the joints are told in SAFE: hold the posture by a slow law, or sink slowly.

Both know the nominal robot's inertia, as the adviser does: a loop that has to stand a delay of
milliseconds needs to know how light the joints are. Neither knows its weight.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from equipoise.contacts import ContactStack
from equipoise.contacts.pull import least_regulated
from equipoise.control.base_wrench.foot_bounds import ReactionBounds
from equipoise.control.interface import Command, Measurement, Reference
from equipoise.control.passivity.gain_advice import advise_for_soft_floor, inertia_matrix
from equipoise.control.passivity.gains import ControlGains
from equipoise.control.passivity.law import PassivityController
from equipoise.control.passivity.sign import SignFunction
from equipoise.robots import Robot
from equipoise.spatial import Array

DAMPING_SHARE = 0.4  # of I / delay; the loop dv/dt = -(D/I) v(t - delay) is lost at pi/2
REACTION_TIME = 4.0  # of the delay: how slowly the law looks at the floor's reaction
FORCE_LAYER = 0.5  # [N] within which the force of a hand is regulated without a jump
INTEGRAL_SLOPE = 5.0  # [rad/s^2] of the integral that carries what is not known


class SafeHold:
    """Holds a posture on the contacts of the moment with gains for a loop `delay` [s] late.

    The passivity law with `K_d = kappa M(q)`, kappa from `advise_for_soft_floor`: it starts from
    the torque of the moment, takes the weight over by its reaction and integral, and goes on
    pressing as hands did: one that lies on a wall and that the law did not know of would be driven
    along it. `damping` (na,) [N m s/rad] is what a joint bears with the rest of the robot free.
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
        self._bounds = bounds
        self.damping = joint_damping(robot, robot.q_half_sitting, dt + delay)
        self._law = self._made(contacts)
        self._q, self._still = robot.q_half_sitting.copy(), np.zeros(robot.nv)
        self._lam_ref = np.zeros(self._law.contacts.regulated_rows.size)

    def _made(self, contacts: ContactStack) -> PassivityController:
        return PassivityController(
            self.robot, contacts, self._gains(self.robot.q_half_sitting), self._dt,
            bounds=self._bounds, filter_time=REACTION_TIME * self._delay,
        )  # fmt: skip

    def _gains(self, q: Array) -> ControlGains:
        soft = advise_for_soft_floor(max(self._delay, self._dt), self._dt, INTEGRAL_SLOPE)
        return ControlGains(
            K_d=soft.kappa * inertia_matrix(self.robot, q), alpha=soft.alpha, k_ip=INTEGRAL_SLOPE,
            sgn_p=SignFunction("saturation", soft.layer),
            sgn_F=SignFunction("saturation", FORCE_LAYER), damp_violation=True,
        )  # fmt: skip

    def begin(self, contacts: ContactStack, measured: Measurement, tau: Array) -> None:
        """Hold the measured posture from now on, beginning with the torque `tau` (na,) [N m]."""
        if contacts.contacts != self._law.contacts.contacts:
            self._law = self._made(contacts)
        q = measured.q
        self._q = q.copy()
        pressed = measured.lam[contacts.regulated_rows]
        self._lam_ref = np.maximum(pressed, least_regulated(contacts.contacts))
        self._law.gains = replace(self._gains(q), handover=self._law.gains.handover)
        self._law.reset()
        self._law.take_over(tau)

    @property
    def q(self) -> Array:
        """The posture that is held (nq,)."""
        return self._q

    @property
    def pressed(self) -> Array:
        """What the regulated rows are held at (k,)."""
        return self._lam_ref

    def step(self, t: float, measured: Measurement, contacts: ContactStack) -> Command:
        """Return the torque that holds the posture; `measured` as for a controller."""
        if contacts.contacts != self._law.contacts.contacts:
            self.begin(contacts, measured, self._law.tau.copy())
        return self._law.step(t, measured, Reference(self._q, self._still, self._lam_ref))

    def damped(self, rates: Array, carried: Array) -> Array:
        """Return the torque (na,) that brakes joint `rates` (na,) and still carries some weight."""
        known = np.where(np.isfinite(rates), rates, 0.0)
        limit = self.robot.tau_max
        return np.clip(carried - self.damping * known, -limit, limit)

    def state(self) -> dict[str, Any]:
        """Return a copy of the memory."""
        return {"law": self._law.state(), "q": self._q.copy(), "lam_ref": self._lam_ref.copy()}

    def restore(self, state: Mapping[str, Any], contacts: ContactStack) -> None:
        """Continue from what `state` returned, on the contacts that hold."""
        if contacts.contacts != self._law.contacts.contacts:
            self._law = self._made(contacts)
        self._q, self._lam_ref = state["q"].copy(), state["lam_ref"].copy()
        self._law.gains = replace(self._gains(self._q), handover=self._law.gains.handover)
        self._law.restore(state["law"])


def joint_damping(robot: Robot, q: Array, delay: float) -> Array:
    """Return the damping (na,) [N m s/rad] that each joint bears at a delay [s], all others free.

    A share of I / delay with I = 1 / (M^-1)_jj, the least inertia that the joint can meet, so that
    the same damping is stable whatever the feet touch.
    """
    least = 1.0 / np.diag(np.linalg.inv(inertia_matrix(robot, q)))
    return DAMPING_SHARE * least[robot.nv_base :] / delay
