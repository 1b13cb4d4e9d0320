"""What is around the robot: fixed bodies, objects in its hands, objects that it pushes."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal

from pydantic import Field, model_validator

from equipoise.scenarios.schema.base import (
    Name,
    NotNegative,
    Pose,
    Positive,
    Section,
    ShapeSpec,
    Vector3,
)


class FixedBody(Section):
    """A body that never moves."""

    at: Pose = Pose(xyz=[0.0, 0.0, 0.0])
    shapes: Annotated[list[ShapeSpec], Field(min_length=1)]


class WaypointSpec(Pose):
    """A pose to be reached at time `t`; with `stop` the motion comes to rest there."""

    t: NotNegative
    stop: bool = False


def require_increasing(waypoints: list[WaypointSpec]) -> None:
    for before, after in pairwise(w.t for w in waypoints):
        if after <= before:
            raise ValueError(
                f"waypoint at t = {after:g} s lies in the past of the one at {before:g} s"
            )


class HeldObject(Section):
    """A rigid object in the hands, and its path through the world.

    `handles`: where each palm frame holds it, in the axes of the object. The shapes are attached
    to the first handle. The engine rigid takes it as massless; in the engine mujoco it is a free
    body of `mass` [kg], with `friction` on what it lies on, held by `grip`: `rigid` (the hands are
    welded to it until the grasp ends) or `friction` (only pressed between two plates). `carried`:
    the waypoints go along with a robot that walks; they say where the object would be if the robot
    still stood where it began.
    """

    mass: Positive = 0.5
    friction: Positive = 0.6
    grip: Literal["rigid", "friction"] = "rigid"

    shapes: Annotated[list[ShapeSpec], Field(min_length=1)]
    handles: Annotated[dict[str, Pose], Field(min_length=1)]
    waypoints: Annotated[list[WaypointSpec], Field(min_length=1)]
    carried: bool = False

    @model_validator(mode="after")
    def _times_increase(self) -> HeldObject:
        require_increasing(self.waypoints)
        return self


class TravelSpec(Section):
    """A minimum-jerk travel of `distance` between two times, from rest to rest."""

    start: NotNegative
    end: NotNegative
    distance: Positive

    @model_validator(mode="after")
    def _ordered(self) -> TravelSpec:
        if self.end <= self.start:
            raise ValueError("end must be after start")
        return self


class SliderSpec(Section):
    """An object that is pushed over a surface: quasi-static, Coulomb and viscous friction.

    It moves along `direction` (a unit vector of the world) when a hand pushes its `face` with more
    than `friction * mass * 9.81`; every further newton gives 1/`viscosity` [N s/m] of speed.
    `face` [m]: how far behind its origin, against the direction, the pushed face lies. `travel`
    is how it is wanted to move. `felt` [m] under it lets it slide without a chatter of its corners
    in the engine mujoco; it sinks in by a part of it.
    """

    at: Pose
    shapes: Annotated[list[ShapeSpec], Field(min_length=1)]
    direction: Vector3
    face: NotNegative
    mass: Positive
    friction: Positive
    viscosity: Positive
    felt: NotNegative = 0.0
    travel: TravelSpec

    @model_validator(mode="after")
    def _unit(self) -> SliderSpec:
        if abs(sum(x * x for x in self.direction) - 1.0) > 1e-6:
            raise ValueError("direction must have length 1")
        return self

    @property
    def coulomb(self) -> float:
        """The force [N] below which it stays put."""
        return self.friction * self.mass * 9.81


class WorldSpec(Section):
    """Fixed bodies, objects held by the robot, and objects it pushes, by name."""

    bodies: dict[Name, FixedBody] = {}
    objects: dict[Name, HeldObject] = {}
    sliders: dict[Name, SliderSpec] = {}
