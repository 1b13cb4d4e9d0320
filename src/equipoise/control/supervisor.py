"""Watches over a control law: named modes, substitutes for lost sensors, a safe end.

Whatever it is given, it returns a finite torque within the limits and never raises on values.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pinocchio as pin

from equipoise.contacts import ContactStack
from equipoise.contacts.pull import least_regulated
from equipoise.control.base_wrench.foot_bounds import ReactionBounds
from equipoise.control.bridging import Bridge
from equipoise.control.interface import (
    Command,
    Controller,
    ControlStatus,
    Measurement,
    Reference,
)
from equipoise.control.modes import Mode, ModeChange, SupervisorLimits, lost_sensors
from equipoise.control.safe_hold import SafeHold
from equipoise.kinematics.state import NO_ROTATION
from equipoise.spatial import Array
from equipoise.spatial.numbers import real_array, time_of

AT_REST = 0.05  # [rad/s] of every joint
REST_TIME = 0.5  # [s] at rest after which the torque may stop
SETTLING = 0.3  # [s] in which joints that were moving come back to the posture that is held
NOTED_EVERY = 0.02  # [s] between torques that are remembered while the law runs
NOTED = 25  # of them: half a second
WHOLE_FOR = 0.01  # [s] that lost signals must have been back


class Supervisor:
    """Runs a controller and takes over where it cannot go on.

    From RUN and DEGRADED there is a way back. SAFE holds the posture of the moment with a slow law
    of its own (`SafeHold`) and sinks where that cannot be; from a hold that a lost signal began
    there is a way back while `recovery` lasts, from sinking only to STOPPED, which stays.
    `changes` is the story: every change of the mode with its cause. `bounds` on what the floor
    may be asked for while the posture is held.
    """

    def __init__(
        self,
        controller: Controller,
        limits: SupervisorLimits | None = None,
        *,
        bounds: ReactionBounds | None = None,
    ) -> None:
        self.controller = controller
        self.limits = limits or SupervisorLimits()
        self.mode = Mode.RUN
        self.changes: list[ModeChange] = []
        self.safe = SafeHold(
            controller.robot, controller.contacts, controller.dt, self.limits.delay, bounds=bounds
        )
        self._bridge = Bridge(controller.robot, controller.dt, self.limits.delay)
        self._last: Measurement | None = None
        self._lost_since: float | None = None
        self._contacts = controller.contacts
        self._tau = np.zeros(controller.robot.na)  # the newest torque
        self._noted: list[Array] = []  # torques of the last half second in RUN
        self._note_at = -np.inf
        self._safe_since = self._sinking_since = self._rest_since = np.inf
        self._whole_since: float | None = None
        self._may_return = False
        self._ramp_since = -np.inf
        # where the way back to the reference begins, and what is pressed there
        self._q_from: Array | None = None
        self._lam_from = np.zeros(0)

    def step(self, t: float, measured: Measurement, reference: Reference) -> Command:
        """Return the command at time `t` [s].

        Raises: `ShapeError` if an array has the wrong shape, `InputError` if it holds no numbers.
        """
        t = time_of(t)
        measured, reference = self._checked(measured, reference)
        runs = self.mode in (Mode.RUN, Mode.DEGRADED)
        runs = runs or (self.mode is Mode.SAFE and self._comes_back(t, measured, reference))
        command = self._try_law(t, measured, reference) if runs else None
        if command is None:
            command = self._make_safe(t, measured)
        self._tau = command.tau.copy()
        return command

    def saw(self, t: float, measured: Measurement, tau: Array) -> None:
        """Note a complete measurement on which the law ran without anybody else's help.

        Copied: a loop may write every measurement into one array, and scale a torque in place.
        """
        self._last = _copied(measured)
        if self._lost_since is not None:
            self._lost_since = None
            self._bridge.forget()
        self._tau = tau.copy()
        self._contacts = self.controller.contacts
        if t >= self._note_at:
            self._note(t, self._tau)

    def _note(self, t: float, tau: Array) -> None:
        """Remember a torque that carries the robot."""
        self._note_at = t + NOTED_EVERY
        self._noted.append(tau)
        if len(self._noted) > NOTED:
            del self._noted[0]

    def state(self) -> dict[str, Any]:
        """Return a copy of the memory: mode, times, torques, the last measurement, the hold."""
        last = None if self._last is None else tuple(part.copy() for part in self._last)
        return {
            "mode": self.mode.name,
            "last": last,
            "tau": self._tau.copy(),
            "noted": [tau.copy() for tau in self._noted],
            "q_from": None if self._q_from is None else self._q_from.copy(),
            "lam_from": self._lam_from.copy(),
            "safe": self.safe.state() if self.mode is Mode.SAFE else None,
            "bridge": self._bridge.state(),
            **{name: getattr(self, f"_{name}") for name in _TIMES},
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state` returned."""
        self.mode = Mode[state["mode"]]
        self._last = None if state["last"] is None else Measurement(*state["last"])
        self._tau, self._noted = state["tau"].copy(), [tau.copy() for tau in state["noted"]]
        self._q_from = None if state["q_from"] is None else state["q_from"].copy()
        self._lam_from = state["lam_from"].copy()
        for name in _TIMES:
            setattr(self, f"_{name}", state[name])
        self._contacts = self.controller.contacts
        self._bridge.restore(state["bridge"])
        if state["safe"] is not None:
            self.safe.restore(state["safe"], self._contacts)

    def _checked(
        self, measured: Measurement, reference: Reference
    ) -> tuple[Measurement, Reference]:
        """Return both as arrays of the right shapes, NaN let through, a wanted pull not."""
        robot, contacts = self.controller.robot, self.controller.contacts
        sizes = (robot.nq, robot.nv, contacts.size)
        wanted = (robot.nq, robot.nv, contacts.regulated_rows.size)
        taken = Measurement(*_vectors("measured", Measurement._fields, measured, sizes))
        if robot.nq_base == 7 and not abs(math.hypot(*taken.q[3:7]) - 1.0) < NO_ROTATION:
            taken.q[3:7] = np.nan  # says nothing: as if it were lost
        reference = Reference(*_vectors("reference", Reference._fields, reference, wanted))
        pushing = np.maximum(reference.lam_ref, least_regulated(contacts.contacts))
        return taken, reference._replace(lam_ref=pushing)

    def _try_law(self, t: float, measured: Measurement, reference: Reference) -> Command | None:
        complete, lost = self._completed(t, measured, reference)
        if complete is None:
            self._go_safe(t, f"{lost} for longer than {self.limits.patience:g} s", lost=True)
            return None
        reference, way_back = self._on_the_way(t, reference)
        trouble = self._trouble(complete, reference)
        if trouble:
            self._go_safe(t, trouble, lost=not _finite(*reference))
            return None
        if lost or not way_back:
            self._enter(t, Mode.DEGRADED if lost else Mode.RUN, lost or "all sensors speak again")
        command = self.controller.step(t, complete, reference)
        if command.status is ControlStatus.HELD:
            self._go_safe(t, "the law gave no finite torque", lost=False)
            return None
        if not lost and t >= self._note_at:
            self._note(t, command.tau.copy())
        return command

    def _completed(
        self, t: float, measured: Measurement, reference: Reference
    ) -> tuple[Measurement | None, str]:
        """Return the measurement with substitutes and what is lost, or None past patience."""
        robot, contacts = self.controller.robot, self.controller.contacts
        forces = self._last.lam if self._last is not None else None
        if self.controller.contacts is not self._contacts:
            self._contacts, forces = self.controller.contacts, None
        state_whole = _finite(measured.q, measured.v)
        forces_whole = _finite(measured.lam)
        if state_whole:
            self._lost_since = None
            self._bridge.forget()
        elif self._lost_since is None:
            self._lost_since = t
        if state_whole and forces_whole:
            self._last = measured
            return measured, ""
        since = self._lost_since
        too_long = since is not None and t - since > self.limits.patience
        if not state_whole and (self._last is None or too_long):
            return None, lost_sensors(robot, contacts, measured)
        lam = measured.lam if forces_whole else self._substitute(measured.lam, forces, reference)
        complete = measured._replace(lam=lam)
        if not state_whole and self._last is not None:
            complete = self._bridge.fill(
                self.controller.contacts,
                complete,
                self._last,
                (reference.q_ref, reference.v_ref),
                ask_contacts=False,
            )
        self._last = complete
        return complete, lost_sensors(robot, contacts, measured)

    def _substitute(self, lam: Array, last: Array | None, reference: Reference) -> Array:
        """Return forces in which a lost regulated row is as wanted, a lost other as it was."""
        contacts = self.controller.contacts
        known = np.zeros(contacts.size) if last is None else last.copy()
        known[contacts.regulated_rows] = reference.lam_ref
        return _patched(lam, known)

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
        if tilt > limits.tilt:
            return f"the base is tilted by {tilt:.2f} rad"
        rates = np.abs(measured.v[robot.nv_base :])
        over = int(np.argmax(rates / robot.v_max))
        if not rates[over] <= limits.overspeed * robot.v_max[over]:
            return (
                f"{robot.joint_names[over]} moves at {rates[over]:.1f} rad/s, "
                f"its limit is {robot.v_max[over]:.1f}"
            )
        return ""

    # -- safe -----------------------------------------------------------------------------------

    def give_up(self, t: float, cause: str) -> None:
        """Leave the law for good at time `t` [s], for a cause that somebody else sees."""
        if self.mode in (Mode.RUN, Mode.DEGRADED):
            self._go_safe(time_of(t), cause, lost=False)

    def _go_safe(self, t: float, cause: str, lost: bool) -> None:
        """Leave the law: hold the posture of the moment if it is known, sink if not.

        After a `lost` signal the last torque was a good one and the signal may come back. Else the
        torque is the one that carried the robot over the last half second.
        """
        self._enter(t, Mode.SAFE, cause)
        self._safe_since, self._may_return, self._whole_since = t, lost, None
        self._sinking_since = self._rest_since = np.inf
        if self._last is None or not self._noted:
            self._sink(t, "")
            return
        if not lost:
            self._tau = self._carrying()
        self.safe.begin(t, self.controller.contacts, self._last, self._tau)
        self._bridge.hand_over()

    def _carrying(self) -> Array:
        """Return the torque (na,) that has carried the robot while the law ran."""
        if not self._noted:
            return np.zeros(self.controller.robot.na)
        return np.asarray(np.median(self._noted, axis=0))

    def _make_safe(self, t: float, measured: Measurement) -> Command:
        """Return what the joints are told while the law is off."""
        if self.mode is Mode.SAFE and self._sinking_since == np.inf:
            command = self._try_hold(t, measured)
            if command is not None:
                return command
        return self._sunk(t, measured)

    def _try_hold(self, t: float, measured: Measurement) -> Command | None:
        """Return the torque that holds the posture, None if it cannot be held any longer."""
        robot, contacts, last = self.controller.robot, self.controller.contacts, self._last
        if last is None or not np.isfinite(measured.q[robot.nq_base :]).any():
            self._sink(t, "no joint is measured")
            return None
        same = last.lam.shape == measured.lam.shape  # contacts may have come and gone meanwhile
        forces = _patched(measured.lam, last.lam if same else np.zeros_like(measured.lam))
        known = self._bridge.fill(
            contacts,
            measured._replace(lam=forces),
            last,
            self.safe.wanted(t),
            ask_contacts=True,
        )
        away = self._away(t, known.q)
        if away:
            self._sink(t, away)
            return None
        blind = not _finite(measured.q[: robot.nq_base], measured.v[: robot.nv_base])
        command = self.safe.step(t, known, contacts, blind=blind)
        if command.status is ControlStatus.HELD:
            self._sink(t, "the posture cannot be held")
            return None
        self._last = known
        return _unnamed(command.tau, robot.nv, contacts)

    def _away(self, t: float, q: Array) -> str:
        """Return how far the robot has come from the posture that is held, empty if near.

        What was moving when the hold began is given a moment to come back.
        """
        robot, limits = self.controller.robot, self.limits
        with np.errstate(all="ignore"):
            dq = pin.difference(robot.model, self.safe.q, q)
        joints = np.abs(dq[robot.nv_base :])
        tilt = float(np.linalg.norm(dq[3:6])) if robot.nv_base == 6 else 0.0
        settled = t - self._safe_since > SETTLING
        if not float(joints.max(initial=0.0)) <= (limits.hold_error if settled else np.pi):
            name = robot.joint_names[int(np.argmax(joints))]
            return f"{name} is {joints.max():.2f} from the posture that was held"
        if not tilt <= limits.hold_tilt:
            return f"the base has tilted by {tilt:.2f} rad from the posture that was held"
        return ""

    def _sink(self, t: float, why: str) -> None:
        """Give up holding: let the weight down."""
        self._sinking_since, self._may_return = t, False
        if why:
            self.changes.append(ModeChange(t, self.mode, f"sinking: {why}"))

    def _sunk(self, t: float, measured: Measurement) -> Command:
        """Return damping, with less and less of the torque that carried the robot."""
        robot = self.controller.robot
        rates = measured.v[robot.nv_base :]
        if self.mode is Mode.SAFE:
            self._look_for_rest(t, rates)
        tau = np.zeros(robot.na)
        if self.mode is Mode.SAFE:
            share = max(1.0 - (t - self._sinking_since) / max(self.limits.sinking, 1e-9), 0.0)
            tau = self.safe.damped(self._posture(measured), rates, share * self._carrying())
        return _unnamed(tau, robot.nv, self.controller.contacts)

    def _posture(self, measured: Measurement) -> Array:
        """Return where the joints are (nq,), as far as anybody knows; what is not known stays."""
        robot, last = self.controller.robot, self._last
        q = robot.q_half_sitting.copy() if last is None else last.q.copy()
        joints = measured.q[robot.nq_base :]
        q[robot.nq_base :] = np.where(np.isfinite(joints), joints, q[robot.nq_base :])
        return q

    def _look_for_rest(self, t: float, rates: Array) -> None:
        """Stop where everything has come to rest, or where nothing can be damped."""
        over = t - self._sinking_since >= self.limits.sinking
        if over and not np.isfinite(rates).any():
            self._enter(t, Mode.STOPPED, "no joint velocity is measured to damp")
            return
        if not np.nanmax(np.abs(rates), initial=0.0) < AT_REST:
            self._rest_since = np.inf
        elif self._rest_since == np.inf:
            self._rest_since = t
        if over and t - self._rest_since >= REST_TIME:
            self._enter(t, Mode.STOPPED, "the joints have come to rest")

    # -- and back -------------------------------------------------------------------------------

    def _comes_back(self, t: float, measured: Measurement, reference: Reference) -> bool:
        """Tell whether lost signals are back in time; then the law begins anew."""
        if not self._may_return or t - self._safe_since > self.limits.recovery:
            return False
        if not _finite(*measured, *reference):
            self._whole_since = None
            return False
        if self._whole_since is None:
            self._whole_since = t
        if t - self._whole_since < WHOLE_FOR:
            return False
        self._last, self._lost_since = measured, None
        self._bridge.forget()
        self._ramp_since, self._q_from = t, measured.q.copy()
        self._lam_from = self.safe.pressed.copy()
        self.controller.reset()
        self.controller.take_over(self._tau)
        back = f"all sensors speak again: back to the reference within {self.limits.ramp:g} s"
        self._enter(t, Mode.DEGRADED, back)
        return True

    def _on_the_way(self, t: float, reference: Reference) -> tuple[Reference, bool]:
        """Return the reference, and whether it is still led over from where the robot was held."""
        if self._q_from is None or not _finite(*reference):
            return reference, False
        x = (t - self._ramp_since) / max(self.limits.ramp, 1e-9)
        if x >= 1.0:
            self._q_from = None
            return reference, False
        model, far = self.controller.robot.model, reference.q_ref
        share = x**3 * (10.0 - 15.0 * x + 6.0 * x * x)
        rate = 30.0 * x * x * (1.0 - x) ** 2 / max(self.limits.ramp, 1e-9)
        q_ref = pin.interpolate(model, self._q_from, far, share)
        v_ref = share * reference.v_ref + rate * pin.difference(model, self._q_from, far)
        pressed = self._lam_from
        if pressed.shape != reference.lam_ref.shape:  # contacts came or went meanwhile
            pressed = np.zeros_like(reference.lam_ref)
        return Reference(q_ref, v_ref, pressed + share * (reference.lam_ref - pressed)), True

    def _enter(self, t: float, mode: Mode, cause: str) -> None:
        if mode is self.mode:
            return
        self.mode = mode
        self.changes.append(ModeChange(t, mode, cause))


_TIMES = (
    "lost_since", "note_at", "safe_since", "sinking_since", "rest_since", "whole_since",
    "may_return", "ramp_since",
)  # fmt: skip


def _unnamed(tau: Array, nv: int, contacts: ContactStack) -> Command:
    """Return a torque that is not of the law."""
    nothing = np.zeros(nv)
    return Command(
        tau, ControlStatus.HELD, nothing, np.zeros(contacts.supporting_rows.size), nothing
    )


def _copied(measured: Measurement) -> Measurement:
    return Measurement(measured.q.copy(), measured.v.copy(), measured.lam.copy())


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
