"""What a person may change while a simulation runs, and how each change gets into the log.

An `Operator` (the live viewer, a test) is asked once a tick; the `OperatorPort` applies what is
requested.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Protocol

import numpy as np

from equipoise.control import ControlGains, PassivityController
from equipoise.errors import InputError, NameNotFoundError
from equipoise.kinematics import KinematicsEvaluator
from equipoise.physics import PhysicsState
from equipoise.runlog import Channel
from equipoise.spatial import Array

if TYPE_CHECKING:
    from equipoise.simulation.simulation import Simulation

DAMPING = "K_d_factor"
GAIN_UNITS = {
    "alpha": "1/s",
    "beta_p": "1/s",
    "k_ip": "rad/s^2",
    "beta": "1/kg",
    "beta_F": "1/s",
    "k_iF": "N",
    "mu": "1/(N s)",
    "eta": "1/s",
}


class StopRequested(Exception):
    """A person asked to end the run; what was computed stays in the log."""


@dataclass(frozen=True)
class OperatorRequest:
    """Everything that is asked for now; the default asks for nothing.

    `push` (3,) [N], world axes, acts at the origin of frame `push_frame`. `gains` replaces gains
    by the paper's letters; `damping_factor` multiplies K_d. `forces` is added to the wanted
    multiplier of a row, named "contact/row" [N or N m].
    """

    push: tuple[float, float, float] = (0.0, 0.0, 0.0)
    push_frame: str = ""
    damping_factor: float = 1.0
    gains: Mapping[str, float] = field(default_factory=dict)
    forces: Mapping[str, float] = field(default_factory=dict)


class Operator(Protocol):
    """Whoever steers a running simulation."""

    paused_s: float

    def before_tick(self, t: float) -> OperatorRequest | None:
        """Return new request, None for no news; may wait (a pause) and count it in `paused_s`.

        Raises: `StopRequested`.
        """

    def after_tick(self, t: float, values: Mapping[str, Array]) -> None:
        """See what the tick at time `t` [s] logs."""


class OperatorPort:
    """Applies request to a simulation; `changes` says in sentences what was changed when."""

    def __init__(self, simulation: Simulation, operator: Operator) -> None:
        self.operator = operator
        self.request = OperatorRequest()
        self.changes: list[str] = []
        self._simulation = simulation
        self._gains = simulation.controller.gains
        self._kinematics = KinematicsEvaluator(simulation.robot)
        self._push_point = np.full(3, np.nan)
        self._rows = [
            f"{contact.name}/{label}"
            for contact in simulation.setup.contacts.contacts
            for label in contact.regulated
        ]
        for contact in simulation.setup.contacts.contacts:
            names = [f"{contact.name}/{label}" for label in contact.regulated]
            wanted = simulation.wanted_forces[contact.name]
            simulation.wanted_forces[contact.name][:] = [
                self._with_offset(name, one) for name, one in zip(names, wanted, strict=True)
            ]

    @property
    def channels(self) -> list[Channel]:
        """What is logged besides: the push and the gains of every tick."""
        return [
            Channel("push", ("fx", "fy", "fz"), "N", "push of a person, world axes"),
            Channel("push_point", ("x", "y", "z"), "m", "where it acts, world axes; NaN without"),
            Channel(
                "gains",
                (DAMPING, *GAIN_UNITS),
                ("", *GAIN_UNITS.values()),
                "gains of the law, K_d as a multiple of what the scenario gives",
            ),
        ]

    def before_tick(self, t: float, state: PhysicsState) -> None:
        """Ask, and apply what is wished.

        Raises: `StopRequested`.
        """
        request = self.operator.before_tick(t)
        if request is not None and request != self.request:
            self._take(t, request)

    def after_tick(self, t: float, values: dict[str, Array]) -> None:
        """Add what was wished to the logged values and show them."""
        gains = self._simulation.controller.gains
        values["push"] = np.array(self.request.push, dtype=float)
        values["push_point"] = self._push_point
        values["gains"] = np.array(
            [self.request.damping_factor, *(getattr(gains, name) for name in GAIN_UNITS)]
        )
        self.operator.after_tick(t, values)

    def _take(self, t: float, request: OperatorRequest) -> None:
        try:
            gains = self._checked(request)
        except InputError as error:
            self.changes.append(f"t = {t:.3f} s: refused: {error}")
            return
        retune(self._simulation.controller, gains)
        self.changes += [f"t = {t:.3f} s: {what}" for what in _differences(self.request, request)]
        self.request = request

    def _checked(self, request: OperatorRequest) -> ControlGains:
        for kind, names, known in (
            ("gain", request.gains, tuple(GAIN_UNITS)),
            ("regulated row", request.forces, self._rows),
        ):
            for name in names:
                if name not in known:
                    raise NameNotFoundError(kind, name, known)
        if any(request.push):
            self._simulation.robot.frame_id(request.push_frame)
        numbers = (*request.push, *request.forces.values())
        if not np.isfinite(numbers).all():
            raise InputError("a push or a wanted force is not finite", given=numbers)
        return replace(
            self._gains, K_d=request.damping_factor * np.asarray(self._gains.K_d), **request.gains
        )

    def push(self, state: PhysicsState) -> Array:
        """Return the generalised force (nv,) of the person's push at a state."""
        robot = self._simulation.robot
        if not any(self.request.push):
            self._push_point = np.full(3, np.nan)
            return np.zeros(robot.nv)
        kin = self._kinematics.at(state.q, state.v)
        frame = robot.frame_id(self.request.push_frame)
        self._push_point = kin.placement(frame).translation.copy()
        J = kin.jacobian(frame)
        return J[:3].T @ np.array(self.request.push)

    def _with_offset(self, name: str, wanted: Callable[[float], float]) -> Callable[[float], float]:
        return lambda t: wanted(t) + self.request.forces.get(name, 0.0)


def retune(controller: PassivityController, gains: ControlGains) -> None:
    """Give a running controller other gains; its integrals and starting values stay."""
    controller.gains = gains
    controller.K_d = gains.damping_matrix(controller.robot.nv)
    posture, force = controller.posture, controller.force
    posture.alpha, posture.beta_p, posture.k_ip = gains.alpha, gains.beta_p, gains.k_ip
    force.beta_F, force.k_iF = gains.beta_F, gains.k_iF


def _differences(before: OperatorRequest, after: OperatorRequest) -> list[str]:
    told = []
    if (before.push, before.push_frame) != (after.push, after.push_frame):
        x, y, z = after.push
        told.append(f"push ({x:g}, {y:g}, {z:g}) N at {after.push_frame or 'nothing'}")
    if before.damping_factor != after.damping_factor:
        told.append(f"K_d times {after.damping_factor:g}")
    for kind, old, new in (
        ("gain", before.gains, after.gains),
        ("wanted force, added to", before.forces, after.forces),
    ):
        for name in dict.fromkeys((*old, *new)):
            if old.get(name) != new.get(name):
                value = f"{new[name]:g}" if name in new else "as in the scenario"
                told.append(f"{kind} {name}: {value}")
    return told
