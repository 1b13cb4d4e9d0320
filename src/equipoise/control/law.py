"""The control law (24): torques from errors and contact geometry, without a dynamic model.

It takes no inertia, Coriolis or gravity term. The only place where a model of the dynamics enters
at all is outside, once, when the adviser suggests the constant matrix `K_d`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
import pinocchio as pin

from equipoise.contacts import ContactStack, StackedContacts
from equipoise.control.base_wrench import distribute_base_wrench
from equipoise.control.gains import ControlGains
from equipoise.control.manifolds import ForceManifold, PostureManifold
from equipoise.errors import InputError, ShapeError
from equipoise.kinematics import KinematicsEvaluator
from equipoise.robots import Robot
from equipoise.spatial import Array, velocity_transport

_LIGHTEST = 0.05  # share of the mean load below which a foot counts as no lighter


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


class PassivityController:
    """Tracks posture and contact forces; `reset` and then `step` once every `dt` [s].

    Its whole memory: `posture`, `force` (the manifolds), `base_reaction`, `tau`, `u`, `handover`.
    Source: eqs. (21), (24). Differs from the print: `- ds_dF/dt` instead of `+` (only then does
    (26) follow); the rows of J_phi whose force is not regulated have zero force error; the six
    base rows of the torque go to the supporting contacts (`distribute_base_wrench`); integrals
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
        self.reset()

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
        self.contacts = contacts
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
        if not _all_finite(measured, target):
            return self._held()
        q, v = measured.q, measured.v
        dq = pin.difference(self.robot.model, target.q_ref, q)
        dv = v - velocity_transport(q, target.q_ref, target.v_ref)
        stacked = self.contacts.at(self._evaluator.at(q, v, t))
        if not self._started:
            self.posture.start(t, dq, dv)
            self.force.start(t)
            self._started = True
        s = self._extended_error(t, stacked, dq, dv)
        u = self._handed_over(t, self._torque(stacked, s, target.lam_ref))
        base_reaction = self._carry_base(stacked, u, measured.lam)
        wanted = (u - stacked.J_phi[self.contacts.supporting_rows].T @ base_reaction)[6:]
        if not np.isfinite(wanted).all():
            return self._held()
        tau = np.minimum(np.maximum(wanted, -self.robot.tau_max), self.robot.tau_max)
        self.u = u
        self._remember(stacked, measured, target, tau, wanted, base_reaction)
        clamped = bool((tau != wanted).any())
        status = ControlStatus.SATURATED if clamped else ControlStatus.RUN
        return Command(tau, status, u, base_reaction, s)

    def _extended_error(self, t: float, stacked: StackedContacts, dq: Array, dv: Array) -> Array:
        """Return s (nv,). Source: eq. (21). Differs from the print: see the class."""
        s_rp = self.posture.update(t, dq, dv)
        s_rF = np.zeros(self.contacts.size)
        s_rF[self.contacts.regulated_rows] = self.force.update(t)
        s = stacked.project(s_rp) - self.gains.beta * stacked.lift(s_rF)
        if self.gains.damp_violation:
            s += dv - stacked.project(dv)
        return s

    def _torque(self, stacked: StackedContacts, s: Array, lam_ref: Array) -> Array:
        """Return u (nv,), every row actuated. Source: eq. (24). Differs: see the class."""
        gains, force = self.gains, self.force
        along_rows = (
            -lam_ref
            - force.rate_of_s_dF
            + gains.k_iF * np.tanh(gains.mu * force.s_qF)
            + gains.eta * force.s_rF
        )
        return -self.K_d @ s + stacked.J_phi[self.contacts.regulated_rows].T @ along_rows

    def _handed_over(self, t: float, u: Array) -> Array:
        """Return u with what is left of the last switch's difference."""
        if self._switching:
            self.handover, self._handover_t0 = self.u - u, t
            self._switching = False
        return u + self.handover * np.exp(-(t - self._handover_t0) / self.gains.handover)

    def _carry_base(self, stacked: StackedContacts, u: Array, lam: Array) -> Array:
        rows = self.contacts.supporting_rows
        lam_without = lam[rows] - self.base_reaction
        J_base = stacked.J_phi[rows][:, :6]
        return distribute_base_wrench(u[:6], J_base, self._reaction_costs(lam), lam_without)

    def _reaction_costs(self, lam: Array) -> Array:
        """Return the costs of the supporting rows at the loads that were last measured."""
        soles = [c for c in self.contacts.contacts if c.supporting]
        normal = [max(c.normal_force(lam[self.contacts.rows[c.name]]), 0.0) for c in soles]
        mean = sum(normal) / len(normal)
        loads = [
            min(max(n / mean, _LIGHTEST), 1.0 / _LIGHTEST) if mean > 0.0 else 1.0 for n in normal
        ]
        return np.concatenate([c.reaction_costs(x) for c, x in zip(soles, loads, strict=True)])

    def _remember(
        self,
        stacked: StackedContacts,
        measured: Measurement,
        target: Target,
        tau: Array,
        wanted: Array,
        base_reaction: Array,
    ) -> None:
        s_qp_tangent = stacked.project(self.posture.s_qp)
        held = np.zeros(self.robot.nv, dtype=bool)
        # K_d s enters the torque with a minus: a clamp at the top holds negative signs.
        held[6:] = ((wanted > tau) & (s_qp_tangent[6:] < 0.0)) | (
            (wanted < tau) & (s_qp_tangent[6:] > 0.0)
        )
        self.posture.integrate(self.dt, s_qp_tangent, held)
        dlam = measured.lam[self.contacts.regulated_rows] - target.lam_ref
        self.force.integrate(self.dt, dlam, held=False)
        self.base_reaction = base_reaction
        self.tau = tau

    def _held(self) -> Command:
        nothing = np.zeros(self.robot.nv)
        return Command(self.tau, ControlStatus.HELD, nothing, self.base_reaction, nothing)

    def _check_shapes(self, measured: Measurement, target: Target) -> None:
        nq, nv = self.robot.nq, self.robot.nv
        wanted: Sequence[tuple[str, Array, int]] = (
            ("measured q", measured.q, nq),
            ("measured v", measured.v, nv),
            ("measured lam", measured.lam, self.contacts.size),
            ("target q_ref", target.q_ref, nq),
            ("target v_ref", target.v_ref, nv),
            ("target lam_ref", target.lam_ref, self.contacts.regulated_rows.size),
        )
        for name, array, size in wanted:
            if array.shape != (size,):
                raise ShapeError(name, array.shape, (size,))


def _all_finite(measured: Measurement, target: Target) -> bool:
    parts = (measured.q, measured.v, measured.lam, target.q_ref, target.v_ref, target.lam_ref)
    return bool(np.isfinite(np.concatenate(parts)).all())
