"""The schema of a scenario file: every key, its type, its default, its meaning.

This file is the reference of the format; it is long because each key is documented here once.
Lengths are in metres, angles in radians, times in seconds, forces in newtons.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

Vector3 = Annotated[list[float], Field(min_length=3, max_length=3)]
Colour = Annotated[list[float], Field(min_length=4, max_length=4)]
Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]
Name = Annotated[str, Field(min_length=1, pattern=r"^[A-Za-z][A-Za-z0-9_]*$")]


class Section(BaseModel):
    """Base of all sections: unknown keys, NaN and infinities are refused."""

    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False, frozen=True)


class Pose(Section):
    """A placement: `xyz`, then `rpy` = rotation R_z(yaw) R_y(pitch) R_x(roll), as in URDF."""

    xyz: Vector3
    rpy: Vector3 = [0.0, 0.0, 0.0]


class ShapeSpec(Section):
    """One convex shape: exactly one of `box` [x, y, z] and `cylinder` [radius, height]."""

    box: Annotated[list[Positive], Field(min_length=3, max_length=3)] | None = None
    cylinder: Annotated[list[Positive], Field(min_length=2, max_length=2)] | None = None
    at: Pose = Pose(xyz=[0.0, 0.0, 0.0])
    colour: Colour = [0.72, 0.6, 0.45, 1.0]

    @model_validator(mode="after")
    def _one_shape(self) -> ShapeSpec:
        if (self.box is None) == (self.cylinder is None):
            raise ValueError("give exactly one of box and cylinder")
        return self


class FixedBody(Section):
    """A body that never moves."""

    at: Pose = Pose(xyz=[0.0, 0.0, 0.0])
    shapes: Annotated[list[ShapeSpec], Field(min_length=1)]


class WaypointSpec(Pose):
    """A pose to be reached at time `t`; with `stop` the motion comes to rest there."""

    t: NotNegative
    stop: bool = False


class HeldObject(Section):
    """A massless rigid object in the hands, and its way through the world.

    `handles`: where each palm frame holds it, in the axes of the object. The shapes are attached
    to the first handle.
    """

    shapes: Annotated[list[ShapeSpec], Field(min_length=1)]
    handles: Annotated[dict[str, Pose], Field(min_length=1)]
    waypoints: Annotated[list[WaypointSpec], Field(min_length=1)]

    @model_validator(mode="after")
    def _times_increase(self) -> HeldObject:
        times = [w.t for w in self.waypoints]
        for before, after in pairwise(times):
            if after <= before:
                raise ValueError(
                    f"waypoint at t = {after:g} s lies in the past of the one at {before:g} s"
                )
        return self


class WorldSpec(Section):
    """Fixed bodies by name, and objects held by the robot by name."""

    bodies: dict[Name, FixedBody] = {}
    objects: dict[Name, HeldObject] = {}


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


class SoleContactSpec(Section):
    """Six rows: the sole of that name stays where it starts. It supports the robot."""

    kind: Literal["sole"]
    sole: str
    friction: Positive = 0.7


class GraspContactSpec(Section):
    """Six rows: two handles of an object keep their relative pose.

    `regulated`: wanted profile of chosen rows among fx, fy, fz, mx, my, mz (axes of the first
    palm; fz > 0 squeezes).
    """

    kind: Literal["grasp"]
    object: str
    hands: Annotated[list[str], Field(min_length=2, max_length=2)]
    regulated: dict[str, ForceProfile] = {}


ContactSpec = Annotated[SoleContactSpec | GraspContactSpec, Field(discriminator="kind")]


class TaskBase(Section):
    """Common keys: `priority` 1 is served first (level 0 belongs to the contacts)."""

    priority: Annotated[int, Field(ge=1, le=20)]
    enabled: bool = True


class HoldFrameSpec(TaskBase):
    """Keep a frame at its pose of the start."""

    kind: Literal["hold_frame"]
    frame: str
    rate: Positive = 10.0


class HandOnObjectSpec(TaskBase):
    """A palm follows the waypoints of the object it holds."""

    kind: Literal["hand_on_object"]
    hand: str
    object: str
    rate: Positive = 10.0


class ComPolygonSpec(TaskBase):
    """Centre of mass inside the polygon of the sole contacts, moved in by `margin`."""

    kind: Literal["com_polygon"]
    margin: NotNegative = 0.02
    rate: Positive = 3.0


class JointLimitsSpec(TaskBase):
    """Joint positions `margin` inside their limits, speeds below `velocity_share` of theirs."""

    kind: Literal["joint_limits"]
    margin: NotNegative = 0.01
    velocity_share: Annotated[float, Field(gt=0.0, le=1.0)] = 0.95
    rate: Positive = 5.0


class GazeSpec(TaskBase):
    """The camera looks at a point of an object (`offset` in its axes)."""

    kind: Literal["gaze"]
    object: str
    offset: Vector3 = [0.0, 0.0, 0.0]
    rate: Positive = 5.0


class AvoidanceSpec(TaskBase):
    """Pairs of bodies (links, fixed bodies, objects) keep `security` distance.

    `damping` [m/s]: approach speed still allowed at the distance `influence`.
    """

    kind: Literal["avoidance"]
    pairs: Annotated[
        list[Annotated[list[str], Field(min_length=2, max_length=2)]], Field(min_length=1)
    ]
    influence: Positive = 0.08
    security: NotNegative = 0.015
    damping: Positive = 0.25

    @model_validator(mode="after")
    def _ordered(self) -> AvoidanceSpec:
        if self.security >= self.influence:
            raise ValueError("security must be less than influence")
        return self


class PostureSpec(TaskBase):
    """All joints are drawn to a posture: `half_sitting`, with chosen joints elsewhere."""

    kind: Literal["posture"]
    joints: dict[str, float] = {}
    rate: Positive = 1.0


TaskSpec = Annotated[
    HoldFrameSpec
    | HandOnObjectSpec
    | ComPolygonSpec
    | JointLimitsSpec
    | GazeSpec
    | AvoidanceSpec
    | PostureSpec,
    Field(discriminator="kind"),
]


class SignSpec(Section):
    """`sign`, `tanh(x / layer)` or `saturation` = clip(x / layer)."""

    kind: Literal["sign", "tanh", "saturation"] = "saturation"
    layer: Positive = 0.05


class GainsSpec(Section):
    """Gains of the law, with the paper's letters (`equipoise.control.ControlGains` has a table).

    `K_d` is `kappa` [1/s] times the nominal inertia matrix at half-sitting, a constant computed
    once by the gain adviser; `kappa` may be left out, then the adviser chooses it.
    """

    kappa: Positive | None = None
    alpha: Positive = 20.0
    beta_p: Positive = 5.0
    k_ip: NotNegative = 5.0
    beta: Positive = 0.05
    beta_F: Positive = 5.0
    k_iF: NotNegative = 5.0
    mu: Positive = 5.0
    eta: Positive = 20.0
    sgn_p: SignSpec = SignSpec()
    sgn_F: SignSpec = SignSpec(layer=0.5)
    integral_max: Positive = 10.0
    damp_violation: bool = False


class ControlSpec(Section):
    """Control period, hierarchy solver and gains."""

    period: Annotated[float, Field(gt=0.0, le=0.02)] = 0.001
    solver: Literal["active_set", "cascade", "daqp"] = "active_set"
    contact_rate: Positive = 10.0
    gains: GainsSpec = GainsSpec()


class PhysicsSpec(Section):
    """The engine and its step: `substeps` physics steps a control period."""

    engine: Literal["rigid"] = "rigid"
    substeps: Annotated[int, Field(ge=1, le=100)] = 1
    position_gain: NotNegative = 0.1
    velocity_gain: NotNegative = 0.7
    joint_damping: NotNegative = 0.0


class PayloadSpec(Section):
    """An unknown mass [kg] at a point of an object or of a frame; the controller is not told."""

    mass: Positive
    object: str | None = None
    frame: str | None = None
    at: Vector3 = [0.0, 0.0, 0.0]

    @model_validator(mode="after")
    def _one_place(self) -> PayloadSpec:
        if (self.object is None) == (self.frame is None):
            raise ValueError("give exactly one of object and frame")
        return self


class DisturbancesSpec(Section):
    """What the simulated robot has and the controller does not know."""

    payloads: list[PayloadSpec] = []
    mass_scale: Positive = 1.0


class Limit(Section):
    """Bounds on one metric of the finished run."""

    max: float | None = None
    min: float | None = None

    @model_validator(mode="after")
    def _some_bound(self) -> Limit:
        if self.max is None and self.min is None:
            raise ValueError("give max or min")
        return self


class AcceptanceSpec(Section):
    """What the run must show: `after` is where the settled part begins, `limits` by metric name."""

    after: NotNegative = 1.0
    limits: dict[str, Limit] = {}


class Scenario(Section):
    """A whole scenario."""

    name: Name
    title: str = ""
    robot: str = "hrp2"
    duration: Annotated[float, Field(gt=0.0, le=3600.0)]
    seed: Annotated[int, Field(ge=0)] = 0
    world: WorldSpec = WorldSpec()
    contacts: Annotated[dict[Name, ContactSpec], Field(min_length=1)]
    tasks: Annotated[dict[Name, TaskSpec], Field(min_length=1)]
    monitor: list[Annotated[list[str], Field(min_length=2, max_length=2)]] = []
    control: ControlSpec = ControlSpec()
    physics: PhysicsSpec = PhysicsSpec()
    disturbances: DisturbancesSpec = DisturbancesSpec()
    acceptance: AcceptanceSpec = AcceptanceSpec()
