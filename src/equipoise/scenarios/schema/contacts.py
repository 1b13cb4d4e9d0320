"""Contacts of a scenario, one section a kind."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal

from pydantic import AfterValidator, Field, field_validator, model_validator

from equipoise.scenarios.schema.base import NotNegative, Pose, Positive, Section, Vector3


class ForceProfile(Section):
    """Wanted multiplier of a row: values [N or N m] at times, joined by minimum-jerk steps."""

    times: Annotated[list[NotNegative], Field(min_length=1)]
    values: Annotated[list[float], Field(min_length=1)]

    @model_validator(mode="after")
    def _same_length(self) -> ForceProfile:
        if len(self.times) != len(self.values):
            raise ValueError("times and values must have the same length")
        if any(b <= a for a, b in pairwise(self.times)):
            raise ValueError("times must increase")
        return self


def require_push(force: ForceProfile) -> ForceProfile:
    """Return the profile of a contact that cannot pull. Raises: `ValueError`."""
    for t, value in zip(force.times, force.values, strict=True):
        if value < 0.0:
            raise ValueError(
                f"this contact can only push, and it is wanted to pull with {-value:g} N at "
                f"t = {t:g} s; give values from 0 on"
            )
    return force


PushingProfile = Annotated[ForceProfile, AfterValidator(require_push)]


class SoleContactSpec(Section):
    """Six rows: the sole of that name stays where it starts. It supports the robot."""

    kind: Literal["sole"]
    sole: str
    friction: Positive = 0.7


class FootContactSpec(Section):
    """Three rows: the foot of that name, a point, stays where it starts. It supports the robot."""

    kind: Literal["foot"]
    foot: str
    friction: Positive = 0.7


class GraspContactSpec(Section):
    """Six rows: two handles of an object keep their relative pose.

    `regulated`: wanted profile of chosen rows among fx, fy, fz, mx, my, mz (axes of the first
    palm; fz > 0 squeezes). `end`: when the hands let go; never if it is left out.
    """

    kind: Literal["grasp"]
    object: str
    hands: Annotated[list[str], Field(min_length=2, max_length=2)]
    regulated: dict[str, ForceProfile] = {}
    end: Positive | None = None

    @field_validator("regulated")
    @classmethod
    def _squeezes(cls, regulated: dict[str, ForceProfile]) -> dict[str, ForceProfile]:
        if "fz" in regulated:
            require_push(regulated["fz"])
        return regulated


class SurfaceSpec(Section):
    """A smooth surface: exactly one of `sphere` radius, `cylinder` radius, `plane` (true).

    The cylinder's axis and the plane's normal are the z axis of its pose.
    """

    sphere: Positive | None = None
    cylinder: Positive | None = None
    plane: Literal[True] | None = None
    at: Pose

    @model_validator(mode="after")
    def _one(self) -> SurfaceSpec:
        if sum(x is not None for x in (self.sphere, self.cylinder, self.plane)) != 1:
            raise ValueError("give exactly one of sphere, cylinder and plane")
        return self


class SurfaceContactSpec(Section):
    """One row: a point of a frame (`offset` in its axes) slides on a surface without friction.

    `force`: the wanted normal force, compression positive. `start` and `end`: when the point comes
    to the surface and when it lets go; left out, it is there from the beginning, or stays. With one
    of them the surface can only push, in every engine. `ramp` as that of push.
    """

    kind: Literal["surface"]
    frame: str
    offset: Vector3 = [0.0, 0.0, 0.0]
    surface: SurfaceSpec
    start: Positive | None = None
    end: Positive | None = None
    ramp: NotNegative = 0.0
    force: PushingProfile

    @property
    def comes_or_goes(self) -> bool:
        """Whether the contact does not hold for the whole run."""
        return self.start is not None or self.end is not None

    @model_validator(mode="after")
    def _ordered(self) -> SurfaceContactSpec:
        if self.end is not None and self.end <= (self.start or 0.0):
            raise ValueError("end must be after start")
        if self.start is not None and self.start < self.ramp:
            raise ValueError("ramp must not reach back before time 0")
        return self


class PushContactSpec(Section):
    """One row from `start` to `end`: a point of a hand pushes the face of a slider.

    `force`: the wanted normal force without the part that the slider's viscosity asks for on its
    wanted travel, which is added, in equal shares to all hands that push it. `ramp`: how long
    before `start` the motion is led into the contact, and how long after `end` out of it; 0
    switches it. `pad`: what the engine mujoco gives the hand to push with, a flat plate across the
    z axis of its frame or a ball with the point on its skin.
    """

    kind: Literal["push"]
    hand: str
    offset: Vector3 = [0.0, 0.0, 0.0]
    slider: str
    start: NotNegative
    end: NotNegative
    ramp: NotNegative = 0.0
    force: PushingProfile
    pad: Literal["plate", "ball"] = "plate"

    @model_validator(mode="after")
    def _ordered(self) -> PushContactSpec:
        if self.end <= self.start:
            raise ValueError("end must be after start")
        if 0.0 < self.start < self.ramp:
            raise ValueError("ramp must not reach back before time 0")
        return self


ContactSpec = Annotated[
    SoleContactSpec | FootContactSpec | GraspContactSpec | SurfaceContactSpec | PushContactSpec,
    Field(discriminator="kind"),
]
