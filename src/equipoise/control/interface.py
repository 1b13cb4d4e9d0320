"""What every controller is given and gives back, and what it has to offer."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from typing import Any, NamedTuple, Protocol

import numpy as np

from equipoise.contacts import ContactStack
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.spatial.numbers import real_array


class Measurement(NamedTuple):
    """What sensors give: `q` (nq,), `v` (nv,), `lam` (r,) of the stacked contacts."""

    q: Array
    v: Array
    lam: Array


class Reference(NamedTuple):
    """What is wanted now: `q_ref` (nq,), `v_ref` (nv,), `lam_ref` (k,) of the regulated rows."""

    q_ref: Array
    v_ref: Array
    lam_ref: Array


class ControlStatus(Enum):
    """How a tick went; the value is a sentence."""

    RUN = "the law was computed from a complete measurement"
    SATURATED = "at least one torque was clamped to its limit; its integral is held"
    HELD = "the measurement or reference held a NaN or an infinity; the last torque is kept"


class Command(NamedTuple):
    """What a tick returns: `tau` (na,) [N m] within its limits, and how it came about.

    A controller that has them also gives `u` (nv,), what it would do if every degree of freedom had
    a motor, `base_reaction` (k,), the change F of the supporting reactions that carries its base
    rows, and `s` (nv,), its extended error; they are empty otherwise.
    """

    tau: Array
    status: ControlStatus
    u: Array = np.zeros(0)
    base_reaction: Array = np.zeros(0)
    s: Array = np.zeros(0)


ControllerState = Mapping[str, Any]


class Controller(Protocol):
    """Turns a measurement and a reference into joint torques, once every period.

    Its whole memory is one object: two controllers that are continued from one state give the same
    bits.
    """

    @property
    def robot(self) -> Robot:
        """The robot."""

    @property
    def contacts(self) -> ContactStack:
        """The contacts that hold, in the order of the stacked multipliers."""

    @property
    def dt(self) -> float:
        """The period [s]."""

    def reset(self) -> None:
        """Forget everything: the next `step` is the first."""

    def step(self, t: float, measured: Measurement, reference: Reference) -> Command:
        """Return the torque at time `t` [s]. Never raises on values, never exceeds a limit.

        Raises: `ShapeError` or `InputError` for what is no array of the right size.
        """

    def switch(self, contacts: ContactStack) -> None:
        """Let other contacts hold from the next `step` on."""

    def take_over(self, tau: Array) -> None:
        """Begin from joint torques `tau` (na,) [N m] that are measured now."""

    def state(self) -> ControllerState:
        """Return a copy of the whole memory."""

    def restore(self, state: ControllerState) -> None:
        """Continue from a memory that `state` returned."""


def write_vector(name: str, values: Any, into: Array) -> None:
    """Copy numbers from outside into a vector; a NaN is let through, it is a value.

    Raises: `ShapeError`, `InputError`.
    """
    if isinstance(values, np.ndarray) and values.dtype.kind == "f" and values.shape == into.shape:
        into[:] = values
    else:
        into[:] = real_array(name, values, into.shape, finite=False)
