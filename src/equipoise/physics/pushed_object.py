"""An object pushed over a surface: quasi-static, with Coulomb and viscous friction.

It has no inertia: below the Coulomb force it stays put, above it the pushing force is
`coulomb + viscosity * speed`. The hand can only push it, in one direction.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import Literal

from equipoise.errors import InputError


class PushedObjectMode(Enum):
    """What the contact between hand and object does; the value is a sentence."""

    FREE = "the hand does not touch the object"
    STICK = "the hand touches the object, which stays put"
    SLIP = "the hand moves the object"


@dataclass(frozen=True)
class PushedObject:
    """The object behind the one-row contact `contact`.

    `coulomb` [N] is the force below which it does not move, `viscosity` [N s/m] what a unit of
    speed adds. The contact's normal points from the object to the hand; the object moves along
    the negative normal, and its face with it. `pad`: what the engine mujoco pushes with, a flat
    plate or a ball.
    """

    contact: str
    coulomb: float
    viscosity: float
    pad: Literal["plate", "ball"] = "plate"

    def __post_init__(self) -> None:
        if not (0.0 <= self.coulomb < math.inf and 0.0 < self.viscosity < math.inf):
            raise InputError(
                "a slider needs coulomb >= 0 and viscosity > 0",
                given=(self.coulomb, self.viscosity),
                remedy="Without viscosity a pushing force does not decide the speed",
            )


@dataclass
class PushedObjectState:
    """`travel` [m] since the start and `mode`."""

    travel: float = 0.0
    mode: PushedObjectMode = PushedObjectMode.FREE
