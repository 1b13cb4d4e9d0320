"""The control law (24): torques from errors and contact geometry, without a dynamic model.

It takes no inertia, Coriolis or gravity term. The only place where a model of the dynamics enters
at all is outside, once, when the adviser suggests the constant matrix `K_d`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np
import pinocchio as pin

from equipoise.contacts import ContactRows, ContactStack, Factor
from equipoise.contacts.stack import RANK_TOLERANCE
from equipoise.control.gains import ControlGains
from equipoise.control.law_kernels import (
    HELD,
    RUN,
    SATURATED,
    all_finite,
    law_force,
    law_torque,
)
from equipoise.control.manifolds import ForceManifold, PostureManifold
from equipoise.control.support import Support
from equipoise.errors import InputError, ShapeError
from equipoise.kinematics import KinematicsEvaluator
from equipoise.robots import Robot
from equipoise.spatial import Array


@dataclass(frozen=True)
class Measurement:
    """What sensors give: `q` (nq,), `v` (nv,), `lam` (r,) of the stacked contacts."""

    q: Array
    v: Array
    lam: Array


@dataclass(frozen=True)
class Target:
    """What is wanted now: `q_ref` (nq,), `v_ref` (nv,), `lam_ref` (k,) of the regulated rows."""

    q_ref: Array
    v_ref: Array
    lam_ref: Array


class ControlStatus(Enum):
    """How a tick went; the value is a sentence."""

    RUN = "the law was computed from a complete measurement"
    SATURATED = "at least one torque was clamped to its limit; its integral is held"
    HELD = "the measurement or target held a NaN or an infinity; the last torque is kept"


@dataclass(frozen=True)
class Command:
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
    base rows of the torque go to the supporting contacts (`Support`); integrals
    stop while a torque is clamped. With `damp_violation` s also holds `(I - Q_phi) dv`.
    """

    def __init__(
        self,
        robot: Robot,
        contacts: ContactStack,
        gains: ControlGains,
        dt: float,
    ) -> None:
        if not contacts.supporting_rows.size:
            raise InputError(
                "no contact supports the base",
                known=contacts.rows,
                remedy="Mark at least one contact (a sole) as supporting",
            )
        self.robot, self.contacts, self.gains, self.dt = robot, contacts, gains, dt
        self.K_d = gains.damping_matrix(robot.nv)
        self._evaluator = KinematicsEvaluator(robot)
        self._hold(contacts)
        self.reset()

    def _hold(self, contacts: ContactStack) -> None:
        """Make room for the rows of a stack."""
        self.contacts = contacts
        self._rows = ContactRows.of_size(contacts.size, self.robot.nv)
        self._factor = Factor(contacts.size, self.robot.nv)
        self._support = Support(contacts)
        self._plain = _Inputs(self.robot, contacts)

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
        self._check_shapes(measured, target)
        measured, target = self._plain.taken(measured, target)
        q, v, lam = measured.q, measured.v, measured.lam
        if not all_finite(q, v, lam, target.q_ref, target.v_ref, target.lam_ref):
            return self._held()
        self.contacts.fill(self._evaluator.at(q, v, t), self._rows)
        s, u = self._force(t, q, v, target)
        self._hand_over(t, u)
        base_reaction = self._support.reaction(self._rows.J, u, lam, self.base_reaction)
        tau = np.empty(self.robot.na)
        code = self._torque(u, base_reaction, lam, target.lam_ref, tau)
        if code == HELD:
            return self._held()
        self.u, self.base_reaction, self.tau = u, base_reaction, tau
        return Command(tau, _STATUS[code], u, base_reaction, s)

    def _force(self, t: float, q: Array, v: Array, target: Target) -> tuple[Array, Array]:
        """Return s and u (nv,), every row actuated; begin the manifolds if they have not."""
        gains, posture, force, factor = self.gains, self.posture, self.force, self._factor
        starting = not self._started
        if starting:
            posture.t0 = t
            force.start(t)
            self._started = True
        s, u = np.empty(self.robot.nv), np.empty(self.robot.nv)
        factor.rank = law_force(
            q,
            v,
            target.q_ref,
            target.v_ref,
            pin.difference(self.robot.model, target.q_ref, q),
            target.lam_ref,
            self._rows.J,
            factor.L,
            factor.reflectors,
            factor.pivots,
            self.contacts.regulated_rows,
            self.K_d,
            posture.memory,
            force.memory,
            s,
            u,
            starting,
            float(t - posture.t0),
            posture.alpha,
            posture.beta_p,
            posture.k_ip,
            float(t - force.t0),
            force.beta_F,
            force.k_iF,
            gains.beta,
            gains.mu,
            gains.eta,
            RANK_TOLERANCE,
            gains.damp_violation,
        )
        return s, u

    def _hand_over(self, t: float, u: Array) -> None:
        """Add to u what is left of the last switch's difference."""
        if self._switching:
            self.handover, self._handover_t0 = self.u - u, t
            self._switching, self._handing_over = False, True
        if self._handing_over:
            u += self.handover * math.exp(-(t - self._handover_t0) / self.gains.handover)

    def _torque(
        self, u: Array, base_reaction: Array, lam: Array, lam_ref: Array, tau: Array
    ) -> int:
        posture, force, contacts = self.posture, self.force, self.contacts
        return law_torque(
            self._rows.J,
            self._factor.reflectors,
            self._factor.rank,
            contacts.supporting_rows,
            contacts.regulated_rows,
            u,
            base_reaction,
            lam,
            lam_ref,
            self.robot.tau_max,
            posture.memory,
            force.memory,
            tau,
            self.dt,
            posture.bound,
            posture.sgn.code,
            posture.sgn.layer,
            force.sgn.code,
            force.sgn.layer,
        )

    def _held(self) -> Command:
        nothing = np.zeros(self.robot.nv)
        return Command(self.tau, ControlStatus.HELD, nothing, self.base_reaction, nothing)

    def _check_shapes(self, measured: Measurement, target: Target) -> None:
        wanted = (
            ("measured q", measured.q, self.robot.nq),
            ("measured v", measured.v, self.robot.nv),
            ("measured lam", measured.lam, self.contacts.size),
            ("target q_ref", target.q_ref, self.robot.nq),
            ("target v_ref", target.v_ref, self.robot.nv),
            ("target lam_ref", target.lam_ref, self.contacts.regulated_rows.size),
        )
        for name, array, size in wanted:
            if array.shape != (size,):
                raise ShapeError(name, array.shape, (size,))


class _Inputs:
    """Measurement and target in the one memory layout that the kernels are compiled for."""

    def __init__(self, robot: Robot, contacts: ContactStack) -> None:
        nq, nv, k = robot.nq, robot.nv, contacts.regulated_rows.size
        self.measured = Measurement(np.zeros(nq), np.zeros(nv), np.zeros(contacts.size))
        self.target = Target(np.zeros(nq), np.zeros(nv), np.zeros(k))

    def taken(self, measured: Measurement, target: Target) -> tuple[Measurement, Target]:
        own, wanted = self.measured, self.target
        own.q[:], own.v[:], own.lam[:] = measured.q, measured.v, measured.lam
        wanted.q_ref[:], wanted.v_ref[:] = target.q_ref, target.v_ref
        wanted.lam_ref[:] = target.lam_ref
        return own, wanted
