"""What stands around the robot in MuJoCo, in our own words: fixed bodies and loose objects."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import pinocchio as pin

from equipoise.collision.scene import Body
from equipoise.errors import InputError
from equipoise.spatial.numbers import real_array, real_number
from equipoise.spatial.poses import rigid

Grip = Literal["rigid", "friction"]


@dataclass(frozen=True)
class LooseObject:
    """A rigid body with mass [kg] that only its contacts, and perhaps a grip, hold.

    `body` gives name and shapes; it starts at `T_world_start`. `handles` maps frames of the robot
    to their place in the object's axes; with grip `rigid` they are welded to it, with `friction`
    only touching plates hold it. `payloads` are point masses [kg] at points (3,) [m] of it.
    `viscosity` [N s/m] resists sliding. A `felt` [m] below it: what it touches resists from zero on
    over that depth. MuJoCo's own contacts begin with 0.9 of their impedance, and the corners of a
    box that slides then jump on and off: a steady 32 N on 10 kg has a noise of 8 N RMS; with a felt
    of 1 mm it has none, and sinks in by 0.6 mm. What is welded is let go at `release`
    [s]; before `handed_over` [s] a weld also carries what friction is to hold afterwards.
    """

    body: Body
    mass: float
    friction: float
    T_world_start: pin.SE3
    handles: tuple[tuple[str | int, pin.SE3], ...] = ()
    grip: Grip = "rigid"
    payloads: tuple[tuple[float, tuple[float, float, float]], ...] = ()
    viscosity: float = 0.0
    felt: float = 0.0
    release: float = np.inf
    handed_over: float = 0.5

    def __post_init__(self) -> None:
        what = f"loose object {self.body.name!r}"
        rigid(f"the start of {what}", self.T_world_start)
        for _, T in self.handles:
            rigid(f"a handle of {what}", T)
        for name in ("mass", "friction", "viscosity", "felt"):
            value = real_number(f"the {name} of {what}", getattr(self, name))
            if not value >= 0.0:
                raise InputError(f"the {name} of {what} must not be negative", given=value)
        for mass, point in self.payloads:
            real_number(f"a payload of {what}", mass)
            real_array(f"the place of a payload of {what}", point, (3,))

    @property
    def let_go(self) -> float:
        """Time [s] at which the weld opens."""
        return self.release if self.grip == "rigid" else min(self.handed_over, self.release)

    @property
    def name(self) -> str:
        """Name of the object."""
        return self.body.name


@dataclass(frozen=True)
class Surroundings:
    """Fixed bodies and loose objects; `floor_height` [m] is where the floor lies."""

    fixed: tuple[Body, ...] = ()
    loose: tuple[LooseObject, ...] = ()
    floor_height: float | None = 0.0
