"""What stands around the robot in MuJoCo, in our own words: fixed bodies and loose objects."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import pinocchio as pin

from equipoise.world import Body

Grip = Literal["rigid", "friction"]


@dataclass(frozen=True)
class LooseObject:
    """A rigid body with mass [kg] that only its contacts, and perhaps a grip, hold.

    `body` gives name and shapes; it starts at `T_world_start`. `handles` maps frames of the robot
    to their place in the object's axes; with grip `rigid` they are welded to it, with `friction`
    only touching plates hold it. `payloads` are point masses [kg] at points (3,) [m] of it.
    `viscosity` [N s/m] resists sliding (a felt under it).
    """

    body: Body
    mass: float
    friction: float
    T_world_start: pin.SE3
    handles: tuple[tuple[int, pin.SE3], ...] = ()
    grip: Grip = "rigid"
    payloads: tuple[tuple[float, tuple[float, float, float]], ...] = ()
    viscosity: float = 0.0

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
