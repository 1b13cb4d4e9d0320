"""What every section of a scenario file is made of: numbers with a sign, poses, shapes."""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

Vector3 = Annotated[list[float], Field(min_length=3, max_length=3)]
Colour = Annotated[list[float], Field(min_length=4, max_length=4)]
Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]
Name = Annotated[str, Field(min_length=1, max_length=100, pattern=r"^[A-Za-z][A-Za-z0-9_]*$")]


def _printable(text: str) -> str:
    if not text.isprintable():
        raise ValueError("a title is one line of printable characters")
    return text


Title = Annotated[str, Field(max_length=200), AfterValidator(_printable)]


class Section(BaseModel):
    """Base of all sections: unknown keys, NaN and infinities are refused."""

    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False, frozen=True)


class Pose(Section):
    """A placement: `xyz`, then `rpy` = rotation R_z(yaw) R_y(pitch) R_x(roll), as in URDF."""

    xyz: Vector3
    rpy: Vector3 = [0.0, 0.0, 0.0]


class ShapeSpec(Section):
    """One convex shape: exactly one of `box` [x, y, z], `cylinder` [radius, height], `sphere`."""

    box: Annotated[list[Positive], Field(min_length=3, max_length=3)] | None = None
    cylinder: Annotated[list[Positive], Field(min_length=2, max_length=2)] | None = None
    sphere: Positive | None = None
    at: Pose = Pose(xyz=[0.0, 0.0, 0.0])
    colour: Colour = [0.72, 0.6, 0.45, 1.0]

    @model_validator(mode="after")
    def _one_shape(self) -> ShapeSpec:
        if sum(x is not None for x in (self.box, self.cylinder, self.sphere)) != 1:
            raise ValueError("give exactly one of box, cylinder and sphere")
        return self
