"""Watches over a control law: named modes, substitutes for lost sensors, a safe end.

Whatever it is given, it returns a finite torque within the limits and never raises on values.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np
import pinocchio as pin

from equipoise.control.interface import (
    Command,
    Controller,
    ControlStatus,
    Measurement,
    Reference,
)
from equipoise.spatial import Array
from equipoise.spatial.numbers import real_array


class Mode(Enum):
    """What the supervisor lets the robot do; the value is a sentence."""

    RUN = "the law runs on complete measurements"
    DEGRADED = "the law runs on a substitute for a lost measurement"
    SAFE = "the law is off; the joints are only damped"
    STOPPED = "the torque is zero"


@dataclass(frozen=True)
class SupervisorLimits:
    """When a mode is left.

    `patience` [s]: how long a lost position or velocity may be bridged by its last value. A lost
    contact force is bridged for ever. `posture_error` [rad or m] and `tilt` [rad] of the base
    beyond which the law is switched off. `damping_time` [s] after which damping ends in a stop.
    `damping` [N m s/rad] of every joint in SAFE, as a share of its torque limit at 1 rad/s.
    """

    patience: float = 0.02
    posture_error: float = 0.8
    tilt: float = 0.9
    damping_time: float = 2.0
    damping: float = 0.05


@dataclass(frozen=True)
class ModeChange:
    """At time `t` [s] the mode became `mode` because of `cause`."""

    t: float
    mode: Mode
    cause: str

    def __str__(self) -> str:
        return f"t = {self.t:.3f} s: mode {self.mode.name.lower()}: {self.cause}"


class Supervisor:
    """Runs a controller and takes over where it cannot go on.

    From RUN and DEGRADED there is a way back; SAFE leads only to STOPPED, which stays.
    `changes` is the story: every change of the mode with its cause.
    """

    def __init__(self, controller: Controller, limits: SupervisorLimits | None = None) -> None:
        self.controller = controller
        self.limits = limits or SupervisorLimits()
        self.mode = Mode.RUN
        self.changes: list[ModeChange] = []
        self._last: Measurement | None = None
        self._lost_since: float | None = None
        self._safe_since = 0.0
        self._contacts = controller.contacts

    def step(self, t: float, measured: Measurement, reference: Reference) -> Command:
        """Return the command at time `t` [s].

        Raises: `ShapeError` if an array has the wrong shape, `InputError` if it holds no numbers.
        """
        measured, reference = self._checked(measured, reference)
        if self.mode in (Mode.RUN, Mode.DEGRADED):
            command = self._try_law(t, measured, reference)
            if command is not None:
                return command
        return self.damped(t, measured)

    def saw(self, measured: Measurement) -> None:
        """Note a complete measurement on which the law ran without anybody else's help."""
        self._last, self._lost_since = measured, None
        self._contacts = self.controller.contacts

    def state(self) -> dict[str, Any]:
        """Return a copy of the memory: mode, times and the last measurement."""
        last = None if self._last is None else tuple(part.copy() for part in self._last)
        return {
            "mode": self.mode.name,
            "lost_since": self._lost_since,
            "safe_since": self._safe_since,
            "last": last,
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state` returned."""
        self.mode = Mode[state["mode"]]
        self._lost_since, self._safe_since = state["lost_since"], state["safe_since"]
        self._last = None if state["last"] is None else Measurement(*state["last"])
        self._contacts = self.controller.contacts

    def _checked(
        self, measured: Measurement, reference: Reference
    ) -> tuple[Measurement, Reference]:
        """Return both as arrays of the right shapes, NaN let through."""
        robot, contacts = self.controller.robot, self.controller.contacts
        sizes = (robot.nq, robot.nv, contacts.size)
        wanted = (robot.nq, robot.nv, contacts.regulated_rows.size)
        return (
            Measurement(*_vectors("measured", Measurement._fields, measured, sizes)),
            Reference(*_vectors("reference", Reference._fields, reference, wanted)),
        )

    def _try_law(self, t: float, measured: Measurement, reference: Reference) -> Command | None:
        complete, lost = self._completed(t, measured, reference)
        if complete is None:
            self._enter(t, Mode.SAFE, f"{lost} for longer than {self.limits.patience:g} s")
            return None
        trouble = self._trouble(complete, reference)
        if trouble:
            self._enter(t, Mode.SAFE, trouble)
            return None
        self._enter(t, Mode.DEGRADED if lost else Mode.RUN, lost or "all sensors speak again")
        command = self.controller.step(t, complete, reference)
        if command.status is ControlStatus.HELD:
            self._enter(t, Mode.SAFE, "the law gave no finite torque")
            return None
        return command

    def _completed(
        self, t: float, measured: Measurement, reference: Reference
    ) -> tuple[Measurement | None, str]:
        """Return the measurement with substitutes and what is lost, or None past patience."""
        forces = self._last.lam if self._last is not None else None
        if self.controller.contacts is not self._contacts:
            self._contacts, forces = self.controller.contacts, None
        state_whole = _finite(measured.q, measured.v)
        forces_whole = _finite(measured.lam)
        if state_whole:
            self._lost_since = None
        elif self._lost_since is None:
            self._lost_since = t
        if state_whole and forces_whole:
            self._last = measured
            return measured, ""
        since = self._lost_since
        too_long = since is not None and t - since > self.limits.patience
        if not state_whole and (self._last is None or too_long):
            return None, self._whose(measured)
        lam = measured.lam if forces_whole else self._substitute(measured.lam, forces, reference)
        complete = measured._replace(lam=lam)
        if not state_whole and self._last is not None:
            complete = Measurement(
                _patched(measured.q, self._last.q), _patched(measured.v, self._last.v), lam
            )
            if self.controller.robot.nq_base == 7:
                complete.q[3:7] /= np.linalg.norm(complete.q[3:7])
        self._last = complete
        return complete, self._whose(measured)

    def _substitute(self, lam: Array, last: Array | None, reference: Reference) -> Array:
        """Return forces in which a lost regulated row is as wanted, a lost other as it was."""
        contacts = self.controller.contacts
        known = np.zeros(contacts.size) if last is None else last.copy()
        known[contacts.regulated_rows] = reference.lam_ref
        return _patched(lam, known)

    def _whose(self, measured: Measurement) -> str:
        """Return which sensors are lost, in words."""
        robot, lost = self.controller.robot, []
        q_base, v_base = robot.nq_base, robot.nv_base
        if not _finite(measured.q[:q_base], measured.v[:v_base]):
            lost.append("the base")
        missing = ~(np.isfinite(measured.q[q_base:]) & np.isfinite(measured.v[v_base:]))
        if missing.all():
            lost.append("all joints")
        else:
            lost += [name for name, gone in zip(robot.joint_names, missing, strict=True) if gone]
        for name, rows in self.controller.contacts.rows.items():
            if not np.isfinite(measured.lam[rows]).all():
                lost.append(f"the force of {name}")
        return f"no measurement of {', '.join(lost)}"

    def _trouble(self, measured: Measurement, reference: Reference) -> str:
        """Return why the law had better be off, empty if it need not be."""
        limits, robot = self.limits, self.controller.robot
        if not _finite(reference.q_ref, reference.v_ref):
            return "the reference is not finite"
        if not _finite(reference.lam_ref):
            return "the wanted force is not finite"
        with np.errstate(all="ignore"):
            dq = pin.difference(robot.model, reference.q_ref, measured.q)
        worst = int(np.argmax(np.where(np.isnan(dq), np.inf, np.abs(dq))))
        if not abs(dq[worst]) < limits.posture_error:
            return f"{robot.velocity_names[worst]} is {dq[worst]:.2f} from its reference"
        tilt = float(np.linalg.norm(dq[3:6])) if robot.nv_base == 6 else 0.0
        return f"the base is tilted by {tilt:.2f} rad" if tilt > limits.tilt else ""

    def damped(self, t: float, measured: Measurement) -> Command:
        """Return what the joints are told while the law is off: damping, and in the end nothing."""
        robot = self.controller.robot
        rates = measured.v[robot.nv_base :]
        if self.mode is Mode.SAFE and t - self._safe_since > self.limits.damping_time:
            self._enter(t, Mode.STOPPED, f"damped for {self.limits.damping_time:g} s")
        if self.mode is Mode.SAFE and not np.isfinite(rates).any():
            self._enter(t, Mode.STOPPED, "no joint velocity is measured to damp")
        tau = np.zeros(robot.na)
        if self.mode is Mode.SAFE:
            known = np.where(np.isfinite(rates), rates, 0.0)
            tau = -self.limits.damping * robot.tau_max * np.clip(known, -20.0, 20.0)
        tau = np.minimum(np.maximum(tau, -robot.tau_max), robot.tau_max)
        nothing = np.zeros(robot.nv)
        reaction = np.zeros(self.controller.contacts.supporting_rows.size)
        return Command(tau, ControlStatus.HELD, nothing, reaction, nothing)

    def _enter(self, t: float, mode: Mode, cause: str) -> None:
        if mode is self.mode:
            return
        self.mode = mode
        if mode is Mode.SAFE:
            self._safe_since = t
        self.changes.append(ModeChange(t, mode, cause))


def _finite(*arrays: Array) -> bool:
    return all(bool(np.isfinite(array).all()) for array in arrays)


def _vectors(
    whose: str, names: Sequence[str], values: Sequence[object], sizes: Sequence[int]
) -> list[Array]:
    return [
        real_array(f"{whose} {name}", value, (size,), finite=False)
        for name, value, size in zip(names, values, sizes, strict=True)
    ]


def _patched(values: Array, substitute: Array) -> Array:
    return np.where(np.isfinite(values), values, substitute)
