"""What all rivals share: errors, integrals, hand-over, clamping, memory; the law is their own."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from equipoise.contacts import ContactStack
from equipoise.contacts.pull import least_wanted, refuse_pull
from equipoise.control.interface import (
    Command,
    ControllerState,
    ControlStatus,
    Measurement,
    Reference,
)
from equipoise.control.passivity.law import require_support
from equipoise.control.rivals.floor import Floor
from equipoise.control.rivals.gains import RivalGains, require_slow_enough
from equipoise.control.rivals.geometry import ContactGeometry, Rows
from equipoise.robots import Robot
from equipoise.robots.dynamics import JointDynamics
from equipoise.spatial import Array, velocity_transport
from equipoise.spatial.numbers import positive, real_array, real_vector, require_period, time_of

SMOOTHING = 0.005  # [s] of the low pass behind the derivative of v_ref
GAP = 5.0  # periods without a reference after which its derivative is not taken
POSTURE_MAX = 1.0  # [rad/s] of an error that the posture's integral counts at most
FORCE_MAX = 4.0  # [N s] of a force error that its integral keeps at most


@dataclass(frozen=True)
class Tick:
    """What a rival's law sees: the state, its errors, and what is wanted.

    `dq`, `dv`, `s` = dv + alpha dq + k_i z and `a_ref` (nv,) are in axes of the measured base;
    `lam_ref` (k,) is that of the regulated rows; `forces` (r,): the wanted multiplier of every row
    that does not support, zero of those that do.
    """

    t: float
    measured: Measurement
    rows: Rows
    dq: Array
    dv: Array
    s: Array
    a_ref: Array
    lam_ref: Array
    forces: Array


class Wanted(NamedTuple):
    """What a rival wants: `tau` (na,), `u` (nv,) and the supporting force F (k,) behind it."""

    tau: Array
    u: Array
    F: Array


class Rival(ABC):
    """A controller whose law is `wanted(tick)`; everything else of the protocol stands here.

    The acceleration of the reference is the derivative of `v_ref` behind a low pass of 5 ms. The
    wanted multiplier of a regulated row is its reference less `k_f` times the integral of its
    error, of other rows that do not support zero. What the torque would jump by at `take_over` and
    `switch` fades with `handover` [s]. Raises: `InputError`.
    """

    def __init__(
        self,
        robot: Robot,
        contacts: ContactStack,
        gains: RivalGains,
        period: float,
        *,
        handover: float = 0.3,
    ) -> None:
        self.robot, self.dt = robot, require_period(period)
        require_slow_enough(gains, self.dt)
        self.gains, self.handover = gains, positive("handover", handover, "s")
        self.dynamics = JointDynamics(robot.model)
        self._hold(contacts)
        self.reset()

    @abstractmethod
    def wanted(self, tick: Tick) -> Wanted:
        """Return the torque that the law wants, before it is handed over and clamped."""

    def _hold(self, contacts: ContactStack) -> None:
        require_support(self.robot, contacts)
        self.contacts, self.floor = contacts, Floor(contacts)
        self._geometry = ContactGeometry(self.robot, contacts)
        support = contacts.supporting_rows
        self.others = np.setdiff1d(np.arange(contacts.size), support)  # rows that do not support
        self.pressing = np.array(  # of these, the ones that only push
            [
                contacts.rows[c.name].start + c.labels.index(label)
                for c in contacts.contacts
                if not c.supporting
                for label in sorted(c.one_sided)
            ],
            dtype=int,
        )
        self._least = least_wanted(contacts.contacts)

    # -- the protocol ---------------------------------------------------------------------------

    def reset(self) -> None:
        """Forget everything."""
        nv, na = self.robot.nv, self.robot.na
        self.memory: dict[str, Array] = {
            "tau": np.zeros(na),
            "posture": np.zeros(nv),  # integral of dv + alpha dq
            "force": np.zeros(self.contacts.regulated_rows.size),  # integral of the force error
            "clamped": np.zeros(nv, dtype=bool),
            "v_ref": np.zeros(nv),
            "a_ref": np.zeros(nv),
            "t_ref": np.array(np.nan),
            "jump": np.zeros(na),  # what the torque would have jumped by, and when
            "t_jump": np.array(-np.inf),
            "meet": np.array(False),  # whether the next torque begins at `tau`
            "damping": np.zeros((nv, nv)),  # kappa M(q_0), once it was asked for
            **self.own_memory(),
        }

    def own_memory(self) -> dict[str, Array]:
        """Return what a law keeps besides from tick to tick, as it is at first."""
        return {}

    def step(self, t: float, measured: Measurement, reference: Reference) -> Command:
        """Return the torque at time `t` [s]. Never raises on values, never exceeds a limit.

        Raises: `ShapeError`, `InputError` for what is no array of the right size, or if a contact
        that can only push is wanted to pull.
        """
        t = time_of(t)
        measured, reference = self._checked(measured, reference)
        if not all(np.isfinite(part).all() for part in (t, *measured, *reference)):
            return Command(self.memory["tau"].copy(), ControlStatus.HELD)
        tick = self._tick(t, measured, reference)
        wanted = self.wanted(tick)
        if not np.isfinite(wanted.tau).all():
            return Command(self.memory["tau"].copy(), ControlStatus.HELD)
        asked = self._handed_over(t, wanted.tau)
        limit = self.robot.tau_max
        tau = np.minimum(np.maximum(asked, -limit), limit)
        clamped = np.abs(asked) > limit * (1.0 + 1e-9)
        self.memory["tau"] = tau
        self.memory["clamped"] = np.concatenate((np.zeros(self.robot.nv_base, bool), clamped))
        status = ControlStatus.SATURATED if clamped.any() else ControlStatus.RUN
        return Command(tau.copy(), status, wanted.u, wanted.F, tick.s)

    def switch(self, contacts: ContactStack) -> None:
        """Let other contacts hold from the next step on; the torque does not jump."""
        kept = {name: self._force_error(name) for name in contacts.rows}
        self._hold(contacts)
        self.memory["force"] = np.concatenate(
            [np.zeros(0), *(self._or_zeros(kept[c.name], c.regulated) for c in contacts.contacts)]
        )
        self.memory["meet"] = np.array(True)

    def take_over(self, tau: Array) -> None:
        """Begin from joint torques `tau` (na,) [N m] that are measured now.

        Raises: `ShapeError`, `NonFiniteError`.
        """
        self.memory["tau"] = real_vector("tau", tau, self.robot.na)
        self.memory["meet"] = np.array(True)

    def state(self) -> ControllerState:
        """Return a copy of the whole memory, and the contacts that hold."""
        memory = {name: values.copy() for name, values in self.memory.items()}
        return {**memory, "contacts": self.contacts.contacts}

    def restore(self, state: ControllerState) -> None:
        """Continue from a memory that `state` returned."""
        held = state["contacts"]
        if held != self.contacts.contacts:
            self._hold(ContactStack(held))
        self.memory = {n: np.array(values) for n, values in state.items() if n != "contacts"}

    # -- pieces of a tick -----------------------------------------------------------------------

    def _checked(
        self, measured: Measurement, reference: Reference
    ) -> tuple[Measurement, Reference]:
        robot, contacts = self.robot, self.contacts

        def vector(name: str, values: Any, size: int) -> Array:
            return real_array(name, values, (size,), finite=False)

        measured = Measurement(
            vector("measured q", measured.q, robot.nq),
            vector("measured v", measured.v, robot.nv),
            vector("measured lam", measured.lam, contacts.size),
        )
        reference = Reference(
            vector("reference q_ref", reference.q_ref, robot.nq),
            vector("reference v_ref", reference.v_ref, robot.nv),
            vector("reference lam_ref", reference.lam_ref, contacts.regulated_rows.size),
        )
        for (row, least), value in zip(self._least.items(), reference.lam_ref, strict=True):
            refuse_pull(row, least, float(value))
        return measured, reference

    def _tick(self, t: float, measured: Measurement, reference: Reference) -> Tick:
        """Return errors and wanted forces; integrals move on by a period."""
        memory, gains = self.memory, self.gains
        dq = pin.difference(self.robot.model, reference.q_ref, measured.q)
        v_ref = self._seen(measured.q, reference.q_ref, reference.v_ref)
        a_ref = self._seen(measured.q, reference.q_ref, self._acceleration(t, reference.v_ref))
        dv = measured.v - v_ref
        error = dv + gains.alpha * dq
        counted = np.clip(error, -POSTURE_MAX, POSTURE_MAX)
        memory["posture"] = memory["posture"] + self.dt * np.where(memory["clamped"], 0.0, counted)
        s = error + gains.k_i * memory["posture"] if gains.k_i else error
        forces = self._forces(measured, reference)
        rows = self._geometry.at(measured.q, measured.v, t)
        return Tick(t, measured, rows, dq, dv, s, a_ref, reference.lam_ref, forces)

    def _seen(self, q: Array, q_ref: Array, v: Array) -> Array:
        """Return a velocity of the reference in axes of the measured base."""
        return velocity_transport(q, q_ref, v) if self.robot.nv_base else v

    def _acceleration(self, t: float, v_ref: Array) -> Array:
        """Return the acceleration (nv,) of the reference, in axes of its own base."""
        memory = self.memory
        passed = t - float(memory["t_ref"])
        if 0.0 < passed <= GAP * self.dt:
            raw = (v_ref - memory["v_ref"]) / passed
            share = -np.expm1(-passed / SMOOTHING)
            memory["a_ref"] = memory["a_ref"] + share * (raw - memory["a_ref"])
        else:
            memory["a_ref"] = np.zeros(len(v_ref))
        memory["v_ref"], memory["t_ref"] = v_ref.copy(), np.array(t)
        return memory["a_ref"]

    def _forces(self, measured: Measurement, reference: Reference) -> Array:
        """Return the wanted multiplier (r,) of every row, zero where nothing is wanted."""
        memory, regulated = self.memory, self.contacts.regulated_rows
        moved = memory["force"] + self.dt * (measured.lam[regulated] - reference.lam_ref)
        memory["force"] = np.clip(moved, -FORCE_MAX, FORCE_MAX)
        forces = np.zeros(self.contacts.size)
        forces[regulated] = reference.lam_ref - self.gains.k_f * memory["force"]
        forces[self.pressing] = np.maximum(forces[self.pressing], 0.0)
        return forces

    def _handed_over(self, t: float, tau: Array) -> Array:
        """Return the torque with what is left of the last jump."""
        memory = self.memory
        if memory["meet"]:
            memory["jump"], memory["t_jump"] = memory["tau"] - tau, np.array(t)
            memory["meet"] = np.array(False)
        return tau + memory["jump"] * np.exp((memory["t_jump"] - t) / self.handover)

    def _force_error(self, name: str) -> Array | None:
        """Return the integrals of the force errors of a contact that holds, None if it does not."""
        if name not in self.contacts.rows:
            return None
        rows = self.contacts.rows[name]
        regulated = self.contacts.regulated_rows
        return self.memory["force"][(regulated >= rows.start) & (regulated < rows.stop)]

    @staticmethod
    def _or_zeros(kept: Array | None, regulated: tuple[str, ...]) -> Array:
        return np.zeros(len(regulated)) if kept is None or len(kept) != len(regulated) else kept

    def damping(self, tick: Tick) -> Array:
        """Return `D = kappa M(q_0)` (nv, nv), q_0 the posture in which it is first asked for."""
        if not self.memory["damping"].any():
            self.memory["damping"] = self.gains.kappa * self.dynamics.inertia(tick.measured.q)
        return self.memory["damping"]

    def pressed(self, tick: Tick) -> Array:
        """Return the generalised force (nv,) of the wanted multipliers that do not support."""
        return tick.rows.J[self.others].T @ tick.forces[self.others]

    def carried(self, tick: Tick, u: Array, *, bounded: bool) -> Wanted:
        """Return what hands the base rows of `u` (nv,) to the supporting contacts.

        `u` is the whole generalised force that motors and supports are to give together.
        """
        base = self.robot.nv_base
        if not base:
            return Wanted(u, u, np.zeros(0))
        J_S = tick.rows.J[self.contacts.supporting_rows]
        share_out = self.floor.within_bounds if bounded else self.floor.least
        F = share_out(u[:base], J_S[:, :base])
        return Wanted((u - J_S.T @ F)[base:], u, F)
