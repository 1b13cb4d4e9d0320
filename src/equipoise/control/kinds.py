"""The kinds of controllers that a scenario can name (`control.kind`), and how each is made.

The shipped law stands here as None: it is made by whoever runs it, in the workspace of its tick.
Its rivals follow, with gains of their own.
"""

from __future__ import annotations

from collections.abc import Callable

from equipoise.contacts import ContactStack
from equipoise.control.interface import Controller
from equipoise.control.passivity.gains import ControlGains
from equipoise.control.rivals.kinds import RIVALS
from equipoise.errors import InputError, NameNotFoundError
from equipoise.robots import Robot

MakeController = Callable[[Robot, ContactStack, ControlGains, float], Controller]

CONTROLLERS: dict[str, MakeController | None] = {"passivity": None, **RIVALS}


def register_controller(kind: str, make: MakeController) -> None:
    """Let scenarios name a controller; `make(robot, contacts, gains, period)` returns it.

    Raises: `InputError` if the name is taken.
    """
    if kind in CONTROLLERS:
        raise InputError(
            "a controller of this name is known already", given=kind, known=tuple(CONTROLLERS)
        )
    CONTROLLERS[kind] = make


def controller_maker(kind: str) -> MakeController | None:
    """Return what makes controllers of a kind, None for the shipped law.

    Raises: `NameNotFoundError`.
    """
    if kind not in CONTROLLERS:
        raise NameNotFoundError("controller", kind, CONTROLLERS)
    return CONTROLLERS[kind]
