"""How a robot walks: mode, timing, swing, height of its centre of mass, and how it touches."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum

from equipoise.errors import InputError
from equipoise.given import require_kind
from equipoise.spatial.numbers import not_negative, positive, share
from equipoise.walking.swing import SwingShape
from equipoise.walking.timing import WalkTiming

GRAVITY = 9.81  # [m/s^2]


class WalkMode(Enum):
    """How the centre of mass is led; the value is a sentence."""

    PENDULUM = "it falls from foot to foot, as a linear inverted pendulum"
    SLOW = "it is moved over a foot before the other is lifted"


@dataclass(frozen=True)
class WalkSettings:
    """What a walk is planned with.

    `height` [m]: of the centre of mass over the ground. `inward` [m]: how much nearer to the other
    foot than the middle of a sole its load is led. `leg` [s^2]: how far the zero-moment point is
    moved by what swings, for each m/s^2 of the foot; the centre of mass makes room for it.
    Raises: `InputError`.
    """

    height: float
    mode: WalkMode = WalkMode.PENDULUM
    timing: WalkTiming = field(default_factory=WalkTiming)
    swing: SwingShape = field(default_factory=SwingShape)
    inward: float = 0.0
    leg: float = 0.0

    def __post_init__(self) -> None:
        require_kind("the mode of a walk", self.mode, WalkMode)
        require_kind("the timing of a walk", self.timing, WalkTiming)
        require_kind("the swing of a walk", self.swing, SwingShape)
        positive("the height of the centre of mass", self.height, "m")
        not_negative("how far inward the load is led", self.inward, "m")
        not_negative("what a swinging leg weighs in", self.leg, "s^2")

    @property
    def omega(self) -> float:
        """The rate [1/s] at which the pendulum falls."""
        return math.sqrt(GRAVITY / self.height)


@dataclass(frozen=True)
class TouchSettings:
    """How a touchdown is told and taken.

    `load` [N] on a sole, behind the share `earliest` of its swing, is a touchdown. `halt` [s]: how
    long the reference of the foot then takes to stop, `glide` [s]: from there to where the foot
    stands. `level` [m]: up to which difference the ground is where it was planned, and the sole
    gives.
    Raises: `InputError`.
    """

    load: float
    earliest: float = 0.55
    halt: float = 0.04
    bounce: float = 0.008
    glide: float = 0.12
    level: float = 0.005

    def __post_init__(self) -> None:
        for name in ("load", "halt", "bounce", "glide", "level"):
            positive(f"the {name} of a touchdown", getattr(self, name))
        if not share("the share of the swing", self.earliest) < 1.0:
            raise InputError("a touchdown counts from a share of the swing on", given=self.earliest)
