"""What a person may change while a simulation runs, and how each change gets into the log.

An `Operator` (the live viewer, a test) is asked once a tick; the `OperatorPort` applies what is
requested.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from equipoise.contacts.pull import refuse_pull
from equipoise.control import ControlGains
from equipoise.errors import InputError, NameNotFoundError
from equipoise.kinematics import KinematicsEvaluator
from equipoise.physics import PhysicsState
from equipoise.runlog import Channel, TickRecord
from equipoise.spatial import Array
from equipoise.trajectories.scalars import value_of
from equipoise.wbc import WholeBodyController

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
    multiplier of a row, named "contact/row" [N or N m]; of what can only push no pull is made.
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
    """Applies requests to a controller; `changes` says in sentences what was changed when.

    Gains are those of a law that has some: of any other controller none can be changed.
    """

    def __init__(self, controller: WholeBodyController, operator: Operator) -> None:
        self.operator, self.controller = operator, controller
        self.request = OperatorRequest()
        self.changes: list[str] = []
        self._law = controller.law
        self._gains = controller.settings.gains
        self._kinematics = KinematicsEvaluator(controller.robot)
        self._push_point = np.full(3, np.nan)

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

    def before_tick(self, t: float, state: PhysicsState) -> Array | None:
        """Ask, apply what is requested; return the generalised force (nv,) of the push, if any.

        Raises: `StopRequested`.
        """
        request = self.operator.before_tick(t)
        if request is not None and request != self.request:
            self._take(t, request)
        return self._push(state)

    def after_tick(self, t: float, record: TickRecord) -> None:
        """Add what was requested to the logged values and show them."""
        gains = self._law.gains if self._law is not None else self._gains
        record["push"][:] = self.request.push
        record["push_point"][:] = self._push_point
        record["gains"][:] = (
            self.request.damping_factor,
            *(getattr(gains, name) for name in GAIN_UNITS),
        )
        self.operator.after_tick(t, record.views)

    def _take(self, t: float, request: OperatorRequest) -> None:
        try:
            gains = self._checked(t, request)
        except InputError as error:
            self.changes.append(f"t = {t:.3f} s: refused: {error}")
            return
        if self._law is not None:
            self._law.gains = gains
        for row, number in self.controller.rows.items():
            self.controller.offsets[number] = request.forces.get(row, 0.0)
        self.changes += [f"t = {t:.3f} s: {what}" for what in _differences(self.request, request)]
        self.request = request

    def _checked(self, t: float, request: OperatorRequest) -> ControlGains:
        for kind, names, known in (
            ("gain", request.gains, tuple(GAIN_UNITS)),
            ("regulated row", request.forces, tuple(self.controller.rows)),
        ):
            for name in names:
                if name not in known:
                    raise NameNotFoundError(kind, name, known)
        if any(request.push):
            self.controller.robot.frame_id(request.push_frame)
        numbers = (*request.push, *request.forces.values())
        if not np.isfinite(numbers).all():
            raise InputError("a push or a wanted force is not finite", given=numbers)
        for row, added in request.forces.items():
            scalar = self.controller.wants.scalars[self.controller.rows[row]]
            wanted = value_of(scalar, t) + added
            if added < 0.0:
                refuse_pull(
                    row, self.controller.wants.least[row], wanted, f" (with {added:g} added)"
                )
        K_d = request.damping_factor * np.asarray(self._gains.K_d)
        return replace(
            self._gains,
            K_d=K_d,
            **request.gains,  # type: ignore[arg-type]  # names of GAIN_UNITS, numbers all
        )

    def _push(self, state: PhysicsState) -> Array | None:
        """Return the generalised force (nv,) of the person's push at a state."""
        if not any(self.request.push):
            self._push_point.fill(np.nan)
            return None
        kin = self._kinematics.at(state.q)
        self._push_point[:] = kin.placement(self.request.push_frame).translation
        J = kin.jacobian(self.request.push_frame)
        return J[:3].T @ np.array(self.request.push)


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
