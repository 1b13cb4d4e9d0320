"""What a robot's YAML may say: soles, palms, camera, and what its URDF lacks or has wrong."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator


def _printable(text: str) -> str:
    if not text.isprintable():
        raise ValueError("a name is one line of printable characters")
    return text


Name = Annotated[str, Field(min_length=1, max_length=200, strict=True), AfterValidator(_printable)]
Finite = Annotated[float, Field(allow_inf_nan=False, strict=True)]
Metre = Annotated[float, Field(allow_inf_nan=False, ge=-10.0, le=10.0, strict=True)]
Length = Annotated[float, Field(allow_inf_nan=False, gt=0.0, le=10.0, strict=True)]
Positive = Annotated[float, Field(allow_inf_nan=False, gt=0.0, strict=True)]
Place = tuple[Metre, Metre, Metre]
Angles = tuple[Finite, Finite, Finite]


class Entry(BaseModel):
    """Base of all entries: unknown keys are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class SoleEntry(Entry):
    """A sole's rectangle [m] in the axes of its frame."""

    name: Name
    frame: Name
    x_min: Metre
    x_max: Metre
    y_min: Metre
    y_max: Metre

    @model_validator(mode="after")
    def _bounds_in_order(self) -> SoleEntry:
        if self.x_min >= self.x_max or self.y_min >= self.y_max:
            raise ValueError("a sole needs x_min < x_max and y_min < y_max")
        return self


class FootEntry(Entry):
    """A foot that is a point: it touches the ground `radius` [m] below the origin of its frame."""

    name: Name
    frame: Name
    radius: Annotated[float, Field(allow_inf_nan=False, ge=0.0, le=1.0, strict=True)] = 0.0


class PalmEntry(Entry):
    """A hand's contact frame; `skin` [m] is how far out along its z the hand's surface lies."""

    name: Name
    frame: Name
    skin: Annotated[float, Field(allow_inf_nan=False, ge=0.0, le=1.0, strict=True)] = 0.0


class SourceEntry(Entry):
    """Where the URDF is: `file` inside an installed package.

    `extra`: the extra of Equipoise that brings the package, if one does.
    """

    package: Name
    file: Name
    extra: Name | None = None


class FrameEntry(Entry):
    """A frame that the URDF lacks: at `xyz` [m], `rpy` [rad] in the axes of the link `on`."""

    name: Name
    on: Name
    xyz: Place = (0.0, 0.0, 0.0)
    rpy: Angles = (0.0, 0.0, 0.0)


class PlaceEntry(Entry):
    """Where something is in the world: `xyz` [m], `rpy` [rad]."""

    xyz: Place = (0.0, 0.0, 0.0)
    rpy: Angles = (0.0, 0.0, 0.0)


class WheelsEntry(Entry):
    """Limits of a planar base: `speed` [m/s] and `force` [N] along x and y, `turn` [rad/s] and
    `moment` [N m] about z, `reach` [m] each way from where it begins."""

    speed: Positive = 1.0
    turn: Positive = 1.5
    force: Positive = 400.0
    moment: Positive = 150.0
    reach: Positive = 10.0


class CapsuleEntry(Entry):
    """All points nearer than `radius` [m] to the line between two points of the link."""

    start: Place
    end: Place
    radius: Length

    @model_validator(mode="after")
    def _two_points(self) -> CapsuleEntry:
        if self.start == self.end:
            raise ValueError("start and end are one point; write a sphere")
        return self


class ShapeEntry(Entry):
    """One shape of a link: a box [x, y, z], a sphere [radius], or a capsule.

    `xyz` [m] and `rpy` [rad] place a box or a sphere in the axes of the link.
    """

    box: tuple[Length, Length, Length] | None = None
    sphere: Length | None = None
    capsule: CapsuleEntry | None = None
    xyz: Place = (0.0, 0.0, 0.0)
    rpy: Angles = (0.0, 0.0, 0.0)
    collides: bool = True
    shade: Literal["light", "white", "dark"] = "light"

    @model_validator(mode="after")
    def _one_kind(self) -> ShapeEntry:
        if sum(x is not None for x in (self.box, self.sphere, self.capsule)) != 1:
            raise ValueError("give exactly one of box, sphere and capsule")
        if self.capsule is not None and {"xyz", "rpy"} & self.model_fields_set:
            raise ValueError("a capsule lies between start and end, without xyz and rpy")
        return self


class LimitEntry(Entry):
    """Limits of a joint in place of the URDF's [rad, rad/s, N m; m, m/s, N if it slides]."""

    lower: Finite | None = None
    upper: Finite | None = None
    velocity: Positive | None = None
    effort: Positive | None = None


class InertialEntry(Entry):
    """Numbers of a link's <inertial> in place of the URDF's [kg, kg m^2]."""

    mass: Positive | None = None
    ixx: Finite | None = None
    ixy: Finite | None = None
    ixz: Finite | None = None
    iyy: Finite | None = None
    iyz: Finite | None = None
    izz: Finite | None = None


class Extras(Entry):
    """The whole file; every key may be left out."""

    name: Name | None = None
    summary: Name | Literal[""] = ""
    urdf: SourceEntry | Name | None = None
    mjcf: SourceEntry | Name | None = None
    base: Literal["floating", "fixed", "planar"] | None = None
    wheels: WheelsEntry = WheelsEntry()
    base_at: PlaceEntry | None = None
    cylinders_are_capsules: bool = False
    soles: tuple[SoleEntry, ...] = ()
    feet: tuple[FootEntry, ...] = ()
    palms: tuple[PalmEntry, ...] = ()
    camera: Name | None = None
    half_sitting: dict[Name, Finite] | None = None
    frames: tuple[FrameEntry, ...] = ()
    locked: dict[Name, Finite] = {}
    limits: dict[Name, LimitEntry] = {}
    inertials: dict[Name, InertialEntry] = {}
    shapes: dict[Name, tuple[ShapeEntry, ...]] | None = None
    parts: dict[Name, Name | tuple[Name, ...]] = {}

    @model_validator(mode="after")
    def _one_description(self) -> Extras:
        if self.urdf is not None and self.mjcf is not None:
            raise ValueError("give urdf or mjcf, not both")
        return self

    @model_validator(mode="after")
    def _unique_names(self) -> Extras:
        for kind in ("soles", "palms", "frames"):
            names = [entry.name for entry in getattr(self, kind)]
            if kind == "soles":  # both are what a robot stands on
                names += [entry.name for entry in self.feet]
            repeated = sorted({name for name in names if names.count(name) > 1})
            if repeated:
                raise ValueError(f"{kind[:-1]} name given twice: {', '.join(repeated)}")
        return self

    @property
    def links_of_parts(self) -> dict[str, tuple[str, ...]]:
        """Return the links of each part of the body."""
        return {
            part: (links,) if isinstance(links, str) else tuple(links)
            for part, links in self.parts.items()
        }

    @property
    def has_capsules(self) -> bool:
        """Say whether cylinders of the completed URDF stand for capsules."""
        return self.cylinders_are_capsules or self.shapes is not None
