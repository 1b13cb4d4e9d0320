"""The control law (24): torques from errors and contact geometry, without a dynamic model.

It takes no inertia, Coriolis or gravity term. The only place where a model of the dynamics enters
at all is outside, once, when the adviser suggests the constant matrix `K_d`.
"""

from __future__ import annotations

import math
from enum import Enum
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from equipoise.contacts import ContactRows, ContactStack, Factor
from equipoise.contacts.stack import RANK_TOLERANCE
from equipoise.control.base_wrench.bounded import Distribution, ReactionBounds
from equipoise.control.base_wrench.support import Support
from equipoise.control.interface import Inputs, Measurement, Target
from equipoise.control.passivity.gains import ControlGains
from equipoise.control.passivity.kernels import (
    HELD,
    REACTED,
    RUN,
    SATURATED,
    WANTED,
    WHOLE,
    law_tick,
)
from equipoise.control.passivity.manifolds import ForceManifold, PostureManifold
from equipoise.errors import InputError, NonFiniteError, ShapeError
from equipoise.kinematics import KinematicsEvaluator
from equipoise.robots import Robot
from equipoise.spatial import Array


class ControlStatus(Enum):
    """How a tick went; the value is a sentence."""

    RUN = "the law was computed from a complete measurement"
    SATURATED = "at least one torque was clamped to its limit; its integral is held"
    HELD = "the measurement or target held a NaN or an infinity; the last torque is kept"


class Command(NamedTuple):
    """What a tick returns: `tau` (na,) [N m] within its limits, and how it came about.

    `u` (nv,) is the fully actuated law, `base_reaction` (k,) the change F of the supporting
    reactions that carries its base rows, `s` (nv,) the extended error.
    """

    tau: Array
    status: ControlStatus
    u: Array
    base_reaction: Array
    s: Array


_STATUS = {RUN: ControlStatus.RUN, SATURATED: ControlStatus.SATURATED}


class PassivityController:
    """Tracks posture and contact forces; `reset` and then `step` once every `dt` [s].

    Its whole memory: `posture`, `force` (the manifolds), `base_reaction`, `tau`, `u`, `handover`.
    Source: eqs. (21), (24). Differs from the print: `- ds_dF/dt` instead of `+` (only then does
    (26) follow); the rows of J_phi whose force is not regulated have zero force error; the six
    base rows of the torque go to the supporting contacts (`least_reaction`); integrals
    stop while a torque is clamped. With `damp_violation` s also holds `(I - Q_phi) dv`. With
    `bounds` the base wrench is shared out by a `BoundedDistribution`; `distribution` is the last.
    """

    def __init__(
        self,
        robot: Robot,
        contacts: ContactStack,
        gains: ControlGains,
        dt: float,
        *,
        bounds: ReactionBounds | None = None,
    ) -> None:
        if not contacts.supporting_rows.size:
            raise InputError(
                "no contact supports the base",
                known=contacts.rows,
                remedy="Mark at least one contact (a sole) as supporting",
            )
        self.robot, self.contacts, self.gains, self.dt = robot, contacts, gains, dt
        self.bounds = bounds
        self.K_d = gains.damping_matrix(robot.nv)
        self._tau_max = robot.tau_max.copy()  # arrays that may be written reach kernels faster
        self._evaluator = KinematicsEvaluator(robot)
        self._hold(contacts)
        self.reset()

    def _hold(self, contacts: ContactStack) -> None:
        """Make room for the rows of a stack."""
        self.contacts = contacts
        self._rows = ContactRows.of_size(contacts.size, self.robot.nv)
        self._factor = Factor(contacts.size, self.robot.nv)
        self._support = Support(contacts)
        self._distribute = self._support.bounded(self.bounds) if self.bounds else None
        self._plain = Inputs(self.robot, contacts)

    def reset(self) -> None:
        """Forget everything; the next `step` is the time t0 of the manifolds."""
        gains, nv = self.gains, self.robot.nv
        self.posture = PostureManifold(
            nv,
            alpha=gains.alpha,
            beta_p=gains.beta_p,
            k_ip=gains.k_ip,
            sgn=gains.sgn_p,
            bound=gains.integral_max,
        )
        self.force = self._new_force_manifold()
        self.distribution: Distribution | None = None
        self.base_reaction = np.zeros(self.contacts.supporting_rows.size)
        self.tau = np.zeros(self.robot.na)
        self.u = np.zeros(nv)
        self.handover = np.zeros(nv)
        self._handover_t0 = 0.0
        self._handing_over = False
        self._started = False
        self._switching = False

    def switch(self, contacts: ContactStack) -> None:
        """Let other contacts hold from the next `step` on, without a jump of the torque.

        The manifolds start anew there, so that s_qp = 0 and s_qF = 0; the integral of the posture
        stays. What u would jump by is added to it and fades with `gains.handover`.
        Raises: `InputError` if the supporting contacts change (the reaction F has its memory).
        """
        before = [c.name for c in self.contacts.contacts if c.supporting]
        after = [c.name for c in contacts.contacts if c.supporting]
        if before != after:
            raise InputError(
                "the supporting contacts cannot change while running", given=after, known=before
            )
        self._hold(contacts)
        self.force = self._new_force_manifold()
        self._switching = self._started
        self._started = False

    def take_over(self, tau: Array) -> None:
        """Begin from joint torques `tau` (na,) [N m] that are measured now, at the first `step`.

        For a robot that stands under its own servos: without it the first torque is zero but for
        the wanted forces. The difference fades like that of a switch.
        Raises: `ShapeError`.
        """
        if tau.shape != (self.robot.na,):
            raise ShapeError("tau", tau.shape, (self.robot.na,))
        self.u = np.concatenate((np.zeros(6), tau))
        self._switching = True

    def _new_force_manifold(self) -> ForceManifold:
        gains = self.gains
        size = self.contacts.regulated_rows.size
        return ForceManifold(size, beta_F=gains.beta_F, k_iF=gains.k_iF, sgn=gains.sgn_F)

    def step(self, t: float, measured: Measurement, target: Target) -> Command:
        """Return the torque at time `t` [s]. Never raises on values, never exceeds a limit.

        Raises: `ShapeError` if an array has the wrong shape.
        """
        plain = self._plain
        plain.take(measured, target)
        measured, target = plain.measured, plain.target
        try:
            kin = self._evaluator.at(measured.q, measured.v, t)
        except NonFiniteError:
            return self._held()
        self.contacts.fill(kin, self._rows)
        robot = self.robot
        s, u, tau = np.empty(robot.nv), np.empty(robot.nv), np.empty(robot.na)
        base_reaction = np.empty(len(self.base_reaction))
        if not self._started:
            self.posture.t0 = t
            self.force.start(t)
        if self._switching:
            self._handover_t0, self._handing_over = t, True
        outcome = s, u, base_reaction, tau
        if self._distribute is None:
            code = self._law(t, measured, target, *outcome, WHOLE)
        else:
            code = self._law(t, measured, target, *outcome, WANTED)
            if code != HELD:
                base_reaction[:] = self._bounded(u, measured.lam)
                code = self._law(t, measured, target, *outcome, REACTED)
        if code == HELD:
            return self._held()
        self._started, self._switching = True, False
        self.u, self.base_reaction, self.tau = u, base_reaction, tau
        return Command(tau, _STATUS[code], u, base_reaction, s)

    def _law(
        self,
        t: float,
        measured: Measurement,
        target: Target,
        s: Array,
        u: Array,
        base_reaction: Array,
        tau: Array,
        part: int,
    ) -> int:
        """Write the arrays of a command, or a part of them; return how it went."""
        gains, posture, force, factor = self.gains, self.posture, self.force, self._factor
        contacts, support = self.contacts, self._support
        code, factor.rank = law_tick(
            measured.q,
            measured.v,
            measured.lam,
            target.q_ref,
            target.v_ref,
            target.lam_ref,
            pin.difference(self.robot.model, target.q_ref, measured.q),
            self._rows.J,
            factor.L,
            factor.reflectors,
            factor.pivots,
            contacts.regulated_rows,
            contacts.supporting_rows,
            support.normal_rows,
            support.ends,
            support.terms,
            self.K_d,
            self._tau_max,
            posture.memory,
            force.memory,
            self.base_reaction,
            self.u,
            self.handover,
            s,
            u,
            base_reaction,
            tau,
            not self._started,
            self._switching,
            self._share_of_handover(t),
            float(t - posture.t0),
            posture.alpha,
            posture.beta_p,
            posture.k_ip,
            posture.bound,
            posture.sgn.code,
            posture.sgn.layer,
            float(t - force.t0),
            force.beta_F,
            force.k_iF,
            force.sgn.code,
            force.sgn.layer,
            gains.beta,
            gains.mu,
            gains.eta,
            gains.damp_violation,
            RANK_TOLERANCE,
            self.dt,
            part,
            factor.rank,
        )
        return code

    def _bounded(self, u: Array, lam: Array) -> Array:
        """Return the reaction (k,) within the bounds that carries the base rows of `u`."""
        rows = self.contacts.supporting_rows
        lam_0 = lam[rows] - self.base_reaction
        with np.errstate(all="ignore"):
            self.distribution = self._distribute(u[:6], self._rows.J[rows, :6], lam_0)
        return self.distribution.F

    def _share_of_handover(self, t: float) -> float:
        """Return what is left of the last switch's difference at time `t` [s]."""
        if not self._handing_over:
            return 0.0
        return math.exp(-(t - self._handover_t0) / self.gains.handover)

    def _held(self) -> Command:
        nothing = np.zeros(self.robot.nv)
        return Command(self.tau, ControlStatus.HELD, nothing, self.base_reaction, nothing)
