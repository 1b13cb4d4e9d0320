"""Watches over a control law: named modes, substitutes for lost sensors, a safe end.

Whatever it is given, it returns a finite torque within the limits and never raises on values.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np
import pinocchio as pin

from equipoise.compiled.compilation import entrance
from equipoise.control.base_wrench.observer import ReactionObserver
from equipoise.control.interface import Measurement, Target
from equipoise.control.passivity.law import Command, ControlStatus, PassivityController
from equipoise.kinematics.kernels import is_finite
from equipoise.spatial import Array

_LANDED = 0.1  # [s] before it a released robot has not caught its weight: every sole is light


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


_NOTHING = np.zeros(0)


class Supervisor:
    """Runs a `PassivityController` and takes over where it cannot go on.

    From RUN and DEGRADED there is a way back; SAFE leads only to STOPPED, which stays.
    `changes` is the story: every change of the mode with its cause.

    `filter_time` [s] is that of the `ReactionObserver` through which the law sees its supporting
    reaction. Where the law has bounds, `notes` says once for each sole what it was about to do.
    """

    def __init__(
        self,
        controller: PassivityController,
        limits: SupervisorLimits | None = None,
        *,
        filter_time: float = 0.0,
    ) -> None:
        self.controller = controller
        self.limits = limits or SupervisorLimits()
        self.observer = ReactionObserver(filter_time, controller.dt)
        self.notes: dict[str, float] = {}
        self.mode = Mode.RUN
        self.changes: list[ModeChange] = []
        self._last: Measurement | None = None
        self._lost_since: float | None = None
        self._safe_since = 0.0
        self._contacts = controller.contacts

    def step(self, t: float, measured: Measurement, target: Target) -> Command:
        """Return the command at time `t` [s].

        Raises: `ShapeError` if an array has the wrong shape.
        """
        if self.mode in (Mode.RUN, Mode.DEGRADED):
            command = self._try_law(t, measured, target)
            if command is not None:
                return command
        return self._damped(t, measured)

    def _try_law(self, t: float, measured: Measurement, target: Target) -> Command | None:
        complete, lost = self._completed(t, measured, target)
        if complete is None:
            self._enter(t, Mode.SAFE, f"{lost} for longer than {self.limits.patience:g} s")
            return None
        trouble = self._trouble(complete, target)
        if trouble:
            self._enter(t, Mode.SAFE, trouble)
            return None
        self._enter(t, Mode.DEGRADED if lost else Mode.RUN, lost or "all sensors speak again")
        try:
            command = self._command(t, complete, target)
        except (ArithmeticError, np.linalg.LinAlgError) as error:
            self._enter(t, Mode.SAFE, f"the law could not be computed ({error})")
            return None
        if command.status is ControlStatus.HELD:
            self._enter(t, Mode.SAFE, "the law gave no finite torque")
            return None
        return command

    def _command(self, t: float, measured: Measurement, target: Target) -> Command:
        """Return the law's command, its reaction observed."""
        controller = self.controller
        rows = controller.contacts.supporting_rows
        if self.observer.gain == 1.0:  # it shows what is measured
            command = controller.step(t, measured, target)
            self._note(t)
            return command
        F_before = controller.base_reaction
        lam_0 = self.observer.update(measured.lam[rows], F_before)
        lam = measured.lam.copy()
        lam[rows] = lam_0 + F_before  # the law takes its own part off again
        command = controller.step(t, measured._replace(lam=lam), target)
        self._note(t)
        return command

    def _note(self, t: float) -> None:
        """Note what each sole is about to do, once, after the robot has landed."""
        distribution = self.controller.distribution
        if distribution is not None and t >= _LANDED:
            for warning in distribution.warnings:
                self.notes.setdefault(warning, t)

    def _completed(
        self, t: float, measured: Measurement, target: Target
    ) -> tuple[Measurement | None, str]:
        """Return the measurement with substitutes and what is lost, or None past patience."""
        if self.controller.contacts is not self._contacts:
            self._contacts, forces = self.controller.contacts, None
        else:
            forces = self._last.lam if self._last is not None else None
        state_whole = is_finite(measured.q, measured.v)
        forces_whole = is_finite(measured.lam, _NOTHING)
        if state_whole:
            self._lost_since = None
        elif self._lost_since is None:
            self._lost_since = t
        if state_whole and forces_whole:
            self._last = measured
            return measured, ""
        if not state_whole and (self._last is None or t - self._lost_since > self.limits.patience):
            return None, self._whose(measured)
        lam = measured.lam if forces_whole else self._substitute(measured.lam, forces, target)
        complete = measured._replace(lam=lam)
        if not state_whole:
            assert self._last is not None
            complete = Measurement(
                _patched(measured.q, self._last.q), _patched(measured.v, self._last.v), lam
            )
            complete.q[3:7] /= np.linalg.norm(complete.q[3:7])
        self._last = complete
        return complete, self._whose(measured)

    def _substitute(self, lam: Array, last: Array | None, target: Target) -> Array:
        """Return forces in which a lost regulated row is as wanted, a lost other as it was."""
        contacts = self.controller.contacts
        known = np.zeros(contacts.size) if last is None else last.copy()
        known[contacts.regulated_rows] = target.lam_ref
        return _patched(lam, known)

    def _whose(self, measured: Measurement) -> str:
        """Return which sensors are lost, in words."""
        robot, lost = self.controller.robot, []
        if not (np.isfinite(measured.q[:7]).all() and np.isfinite(measured.v[:6]).all()):
            lost.append("the base")
        missing = ~(np.isfinite(measured.q[7:]) & np.isfinite(measured.v[6:]))
        if missing.all():
            lost.append("all joints")
        else:
            lost += [name for name, gone in zip(robot.joint_names, missing, strict=True) if gone]
        for name, rows in self.controller.contacts.rows.items():
            if not np.isfinite(measured.lam[rows]).all():
                lost.append(f"the force of {name}")
        return f"no measurement of {', '.join(lost)}"

    def _trouble(self, measured: Measurement, target: Target) -> str:
        """Return why the law had better be off, empty if it need not be."""
        limits, robot = self.limits, self.controller.robot
        if not is_finite(_plain(target.q_ref), _plain(target.v_ref)):
            return "the reference is not finite"
        if not is_finite(_plain(target.lam_ref), _NOTHING):
            return "the wanted force is not finite"
        dq = pin.difference(robot.model, target.q_ref, measured.q)
        worst, tilt = farthest(dq)
        if not abs(dq[worst]) < limits.posture_error:
            return f"{robot.velocity_names[worst]} is {dq[worst]:.2f} from its reference"
        if tilt > limits.tilt:
            return f"the base is tilted by {tilt:.2f} rad"
        return ""

    def _damped(self, t: float, measured: Measurement) -> Command:
        robot = self.controller.robot
        rates = measured.v[6:]
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
        return Command(tau, ControlStatus.HELD, nothing, self.controller.base_reaction, nothing)

    def _enter(self, t: float, mode: Mode, cause: str) -> None:
        if mode is self.mode:
            return
        self.mode = mode
        if mode is Mode.SAFE:
            self._safe_since = t
        self.changes.append(ModeChange(t, mode, cause))


@entrance
def farthest(dq: np.ndarray) -> tuple[int, float]:
    """Return where |dq| is largest, or not a number, and by how much the base is tilted."""
    worst = 0
    for i in range(dq.shape[0]):
        if not abs(dq[i]) <= abs(dq[worst]):
            worst = i
    return worst, math.sqrt(dq[3] ** 2 + dq[4] ** 2 + dq[5] ** 2)


def _plain(array: Array) -> Array:
    """Return the array in the one layout that kernels are compiled for."""
    return array if array.flags.writeable else array.copy()


def _patched(values: Array, substitute: Array) -> Array:
    return np.where(np.isfinite(values), values, substitute)
