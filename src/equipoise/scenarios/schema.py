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


class FixedBody(Section):
    """A body that never moves."""

    at: Pose = Pose(xyz=[0.0, 0.0, 0.0])
    shapes: Annotated[list[ShapeSpec], Field(min_length=1)]


class WaypointSpec(Pose):
    """A pose to be reached at time `t`; with `stop` the motion comes to rest there."""

    t: NotNegative
    stop: bool = False


def _require_increasing(waypoints: list[WaypointSpec]) -> None:
    for before, after in pairwise(w.t for w in waypoints):
        if after <= before:
            raise ValueError(
                f"waypoint at t = {after:g} s lies in the past of the one at {before:g} s"
            )


class HeldObject(Section):
    """A rigid object in the hands, and its way through the world.

    `handles`: where each palm frame holds it, in the axes of the object. The shapes are attached
    to the first handle. The engine rigid takes it as massless; in the engine mujoco it is a free
    body of `mass` [kg], with `friction` on what it lies on, held by `grip`: `rigid` (the hands are
    welded to it until the grasp ends) or `friction` (only pressed between two plates).
    """

    mass: Positive = 0.5
    friction: Positive = 0.6
    grip: Literal["rigid", "friction"] = "rigid"

    shapes: Annotated[list[ShapeSpec], Field(min_length=1)]
    handles: Annotated[dict[str, Pose], Field(min_length=1)]
    waypoints: Annotated[list[WaypointSpec], Field(min_length=1)]

    @model_validator(mode="after")
    def _times_increase(self) -> HeldObject:
        _require_increasing(self.waypoints)
        return self


class TravelSpec(Section):
    """A minimum-jerk way of `distance` between two times, from rest to rest."""

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
    is the way it is wanted to go.
    """

    at: Pose
    shapes: Annotated[list[ShapeSpec], Field(min_length=1)]
    direction: Vector3
    face: NotNegative
    mass: Positive
    friction: Positive
    viscosity: Positive
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

    `force`: the wanted normal force, compression positive.
    """

    kind: Literal["surface"]
    frame: str
    offset: Vector3 = [0.0, 0.0, 0.0]
    surface: SurfaceSpec
    force: ForceProfile


class PushContactSpec(Section):
    """One row from `start` to `end`: a point of a hand pushes the face of a slider.

    `force`: the wanted normal force without the part that the slider's viscosity asks for on its
    wanted travel, which is added. `ramp`: how long before `start` the motion is led into the
    contact, and how long after `end` out of it; 0 switches it.
    """

    kind: Literal["push"]
    hand: str
    offset: Vector3 = [0.0, 0.0, 0.0]
    slider: str
    start: NotNegative
    end: NotNegative
    ramp: NotNegative = 0.0
    force: ForceProfile

    @model_validator(mode="after")
    def _ordered(self) -> PushContactSpec:
        if self.end <= self.start:
            raise ValueError("end must be after start")
        if 0.0 < self.start < self.ramp:
            raise ValueError("ramp must not reach back before time 0")
        return self


ContactSpec = Annotated[
    SoleContactSpec | GraspContactSpec | SurfaceContactSpec | PushContactSpec,
    Field(discriminator="kind"),
]


class TaskBase(Section):
    """Common keys: `priority` 1 is served first (level 0 belongs to the contacts).

    `window` [start, end]: the task counts between these times only, and fades in after the start
    and out before the end over `ramp` each; 0 switches it. From start 0 on it counts fully.
    """

    priority: Annotated[int, Field(ge=1, le=20)]
    enabled: bool = True
    window: Annotated[list[NotNegative], Field(min_length=2, max_length=2)] | None = None
    ramp: NotNegative = 0.3

    @model_validator(mode="after")
    def _ramps_fit(self) -> TaskBase:
        if self.window is not None and self.window[1] - self.window[0] < max(2 * self.ramp, 1e-9):
            raise ValueError("window must end after it starts, by two ramps at least")
        return self


class HoldFrameSpec(TaskBase):
    """Keep a frame at its pose of the start."""

    kind: Literal["hold_frame"]
    frame: str
    rate: Positive = 10.0


class FrameWaySpec(TaskBase):
    """A frame follows waypoints of its own; with `travel_of` it also goes along with a slider."""

    kind: Literal["frame_way"]
    frame: str
    waypoints: Annotated[list[WaypointSpec], Field(min_length=1)]
    travel_of: str | None = None
    rate: Positive = 10.0

    @model_validator(mode="after")
    def _times_increase(self) -> FrameWaySpec:
        _require_increasing(self.waypoints)
        return self


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
    """The camera looks at a point of an object or slider (`offset` in its axes)."""

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
    | FrameWaySpec
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

    `K_d` is `kappa` [1/s] times the nominal inertia matrix at the start, a constant computed
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
    handover: Positive = 0.3
    damp_violation: bool = False


class ControlSpec(Section):
    """Control period, hierarchy solver, gains, and how the robot is found.

    `distribution` of the base wrench over the soles: `least` cost, or `bounded` so that the floor
    can give the predicted reaction (pressing, in the cones, pressure inside the soles).
    `reaction_filter` [s]: how slowly the measured reaction is followed when it is predicted; zero
    takes it at face value, which no delay survives. `soft_floor_delay` [s]: on a floor that gives
    (engine mujoco) the adviser chooses `kappa`, `alpha` and the layer of `sgn_p` so that the loop
    has a sixfold reserve over this delay, and damps what violates a contact; zero: the gains are
    taken as they are written.

    `start`: `released`, nothing holds it and the first torque is zero; `standing`, it stands under
    its servos and the law takes over the measured joint torques without a jump.
    """

    period: Annotated[float, Field(gt=0.0, le=0.02)] = 0.001
    solver: Literal["active_set", "cascade", "daqp"] = "active_set"
    contact_rate: Positive = 10.0
    start: Literal["released", "standing"] = "released"
    distribution: Literal["least", "bounded"] = "least"
    reaction_filter: NotNegative = 0.02
    soft_floor_delay: NotNegative = 0.003
    gains: GainsSpec = GainsSpec()


class MujocoSpec(Section):
    """What the engine mujoco is told besides (see `equipoise.physics.mujoco.MujocoOptions`).

    `substeps` physics steps a control period; `joint_friction` [N m], `joint_damping`
    [N m s/rad] and `armature` [kg m^2] act at every actuated joint; `sole_friction` and
    `hand_friction` are Coulomb coefficients; `contact_time` [s] is how fast a contact pushes
    back: smaller is stiffer.
    """

    substeps: Annotated[int, Field(ge=1, le=100)] = 2
    joint_friction: NotNegative = 0.2
    joint_damping: NotNegative = 0.2
    armature: NotNegative = 0.05
    sole_friction: Positive = 0.8
    hand_friction: Positive = 0.5
    contact_time: Positive = 0.01


class PhysicsSpec(Section):
    """The engine: `rigid` (contacts hold both ways, as in the paper) or `mujoco`.

    `substeps` (physics steps a control period), the two gains that take back a violated contact,
    and `joint_damping` belong to the engine rigid; `mujoco` has a section of its own.
    """

    engine: Literal["rigid", "mujoco"] = "rigid"
    mujoco: MujocoSpec = MujocoSpec()
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


class LinkScaleSpec(Section):
    """Factors on the true `mass` and `inertia` of what a joint moves."""

    mass: Positive = 1.0
    inertia: Positive = 1.0


class DisturbancesSpec(Section):
    """What the simulated robot has and the controller does not know.

    `links`: factors by the name of a link; everything fixed to the link takes part.
    """

    payloads: list[PayloadSpec] = []
    mass_scale: Positive = 1.0
    links: dict[str, LinkScaleSpec] = {}


class SensorSpec(Section):
    """Errors of one kind of sensor, in its unit.

    `noise`: standard deviation a tick; `bias`: standard deviation of a constant drawn once;
    `filter_time` [s] of a first-order low pass; `delay` [s], rounded up to whole ticks.
    """

    noise: NotNegative = 0.0
    bias: NotNegative = 0.0
    filter_time: NotNegative = 0.0
    delay: NotNegative = 0.0


class SilenceSpec(Section):
    """A sensor that says nothing new from `start` on, until `end` if that is given.

    `sensor`: joint_position, joint_velocity, base, a joint or a contact. `reading`: `nan` gives
    none, `frozen` repeats the last value.
    """

    sensor: str
    start: NotNegative
    end: NotNegative | None = None
    reading: Literal["nan", "frozen"] = "nan"


class SensorsSpec(Section):
    """What is measured of the true state. Units: rad, rad/s, m, m/s, N, N m."""

    joint_position: SensorSpec = SensorSpec()
    joint_velocity: SensorSpec = SensorSpec()
    base_position: SensorSpec = SensorSpec()
    base_angle: SensorSpec = SensorSpec()
    base_velocity: SensorSpec = SensorSpec()
    base_rate: SensorSpec = SensorSpec()
    force: SensorSpec = SensorSpec()
    moment: SensorSpec = SensorSpec()


class PushSpec(Section):
    """A `force` [N], world axes, at the origin of `frame` for `duration` [s] from `start` on."""

    frame: str
    force: Vector3
    start: NotNegative
    duration: Positive


class FaultsSpec(Section):
    """What goes wrong on purpose.

    `measurement_delay` and `command_delay` [s] are rounded up to whole ticks. `missed_ticks`:
    probability that a control tick comes one period late. `torque_share`: share of each torque
    limit that the motors still give. `silences`: sensors that are lost.
    """

    pushes: list[PushSpec] = []
    measurement_delay: NotNegative = 0.0
    command_delay: NotNegative = 0.0
    missed_ticks: Annotated[float, Field(ge=0.0, lt=1.0)] = 0.0
    torque_share: Annotated[float, Field(ge=0.0, le=1.0)] = 1.0
    silences: list[SilenceSpec] = []


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
    sensors: SensorsSpec = SensorsSpec()
    faults: FaultsSpec = FaultsSpec()
    acceptance: AcceptanceSpec = AcceptanceSpec()
