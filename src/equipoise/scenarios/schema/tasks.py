"""Tasks of a scenario, one section a kind."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from equipoise.scenarios.schema.base import NotNegative, Pose, Positive, Section, Vector3
from equipoise.scenarios.schema.world import WaypointSpec, require_increasing


class TaskBase(Section):
    """Common keys: `priority` 1 is served first (level 0 belongs to the contacts).

    `window` [start, end]: the task counts between these times only, and fades in after the start
    and out before the end over `ramp` each; 0 switches it. From start 0 on it counts fully.
    `weight`: how much its shortfall counts beside others of its priority. `ease` [1/s]: how fast
    its rows let a velocity change, so that the reference has no kinks; left out, at once.
    """

    priority: Annotated[int, Field(ge=1, le=20)]
    enabled: bool = True
    window: Annotated[list[NotNegative], Field(min_length=2, max_length=2)] | None = None
    ramp: NotNegative = 0.3
    weight: Annotated[float, Field(ge=1e-3, le=1e3)] = 1.0
    ease: Positive | None = None

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


class AlongSpec(TaskBase):
    """A frame whose waypoints may go along: with a slider, `travel_of`, or with a walk, `carried`.

    What is carried is where the frame would be if the robot still stood where it began.
    """

    travel_of: str | None = None
    carried: bool = False


class FramePathSpec(AlongSpec):
    """A frame follows waypoints of its own, which may go along with a slider or a walk.

    `speed` [m/s], `acceleration` [m/s^2], `turn` [rad/s] and `turn_acceleration` [rad/s^2] bound
    the way: legs that are faster take longer, and it is told. `pull` [m/s] and `pull_turn` [rad/s]
    are the most that is asked of the frame to come back when it is behind, and `damping` calms its
    joints then. `calm`: no joint turns quickly, whatever the frame is asked for. Left out it is
    true where a waypoint turns out to be out of reach before the run; the way is then bounded to
    0.5 m/s and 0.7 m/s^2 (1 rad/s, 1.4 rad/s^2) where the file says nothing else.
    """

    kind: Literal["frame_path", "frame_way"]
    frame: str
    waypoints: Annotated[list[WaypointSpec], Field(min_length=1)]
    rate: Positive = 10.0
    speed: Positive | None = None
    acceleration: Positive | None = None
    turn: Positive | None = None
    turn_acceleration: Positive | None = None
    pull: Positive | None = None
    pull_turn: Positive | None = None
    damping: NotNegative | None = None
    calm: bool | None = None

    @model_validator(mode="after")
    def _times_increase(self) -> FramePathSpec:
        require_increasing(self.waypoints)
        return self


class HandOnObjectSpec(TaskBase):
    """A palm follows the waypoints of the object it holds."""

    kind: Literal["hand_on_object"]
    hand: str
    object: str
    rate: Positive = 10.0


class ComPolygonSpec(TaskBase):
    """Centre of mass inside the polygon of the sole contacts, moved in by `margin`.

    If it `leans`, the polygon moves with what hands are wanted to press, and what they are asked
    waits until the robot bears it. Not under a walk, which leans by itself.
    """

    kind: Literal["com_polygon"]
    margin: NotNegative = 0.02
    rate: Positive = 3.0
    leans: bool = False


class JointLimitsSpec(TaskBase):
    """Joint positions `margin` inside their limits, speeds below `velocity_share` of theirs.

    `speeds` [rad/s] bound single joints further; joints that are `frozen` do not move.
    """

    kind: Literal["joint_limits"]
    margin: NotNegative = 0.01
    velocity_share: Annotated[float, Field(gt=0.0, le=1.0)] = 0.95
    rate: Positive = 5.0
    speeds: dict[str, NotNegative] = {}
    frozen: list[str] = []


class JointAccelerationsSpec(TaskBase):
    """Joint accelerations within `share` of what the robot can, so that joints stop in time.

    What it can is found once from the nominal robot: the torque that is left beside holding still,
    over the inertia, and full speed (at most `speed` [rad/s]) after `rise` [s]. `margin`,
    `velocity_share` and `rate` as those of joint_limits.
    """

    kind: Literal["joint_accelerations"]
    share: Annotated[float, Field(gt=0.0, le=1.0)] = 0.5
    rise: Positive = 0.5
    speed: Positive | None = None
    margin: NotNegative = 0.01
    velocity_share: Annotated[float, Field(gt=0.0, le=1.0)] = 0.95
    rate: Positive = 5.0


class FloorSupportSpec(TaskBase):
    """The floor only has to push: where it pushes stays `margin` inside the soles' polygon.

    At least `least` of the weight stays on the soles. Less margin than that of com_polygon. What
    hands are wanted to press counts if it `leans`.
    """

    kind: Literal["floor_support"]
    margin: NotNegative = 0.01
    leans: bool = True
    least: Annotated[float, Field(gt=0.0, le=1.0)] = 0.3


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


class FrameAxesSpec(AlongSpec):
    """Chosen axes of a frame follow waypoints: position only unless rx, ry, rz are among `axes`.

    Waypoints may go along with a slider or a walk. The axes are those of the waypoint; `offset` in
    the frame is the point that goes there.
    """

    kind: Literal["frame_axes"]
    frame: str
    waypoints: Annotated[list[WaypointSpec], Field(min_length=1)]
    axes: Annotated[list[Literal["x", "y", "z", "rx", "ry", "rz"]], Field(min_length=1)] = [
        "x",
        "y",
        "z",
    ]
    offset: Vector3 = [0.0, 0.0, 0.0]
    rate: Positive = 10.0

    @model_validator(mode="after")
    def _times_increase(self) -> FrameAxesSpec:
        require_increasing(self.waypoints)
        return self


class RelativeFrameSpec(TaskBase):
    """A frame follows waypoints that are in the axes of another frame, `relative_to`."""

    kind: Literal["relative_frame"]
    frame: str
    relative_to: str
    waypoints: Annotated[list[WaypointSpec], Field(min_length=1)]
    axes: Annotated[list[Literal["x", "y", "z", "rx", "ry", "rz"]], Field(min_length=1)] = [
        "x",
        "y",
        "z",
        "rx",
        "ry",
        "rz",
    ]
    rate: Positive = 10.0

    @model_validator(mode="after")
    def _times_increase(self) -> RelativeFrameSpec:
        require_increasing(self.waypoints)
        return self


class ComPointSpec(TaskBase):
    """The centre of mass follows the places of waypoints, along `axes` of the world."""

    kind: Literal["com_point"]
    waypoints: Annotated[list[WaypointSpec], Field(min_length=1)]
    axes: Annotated[list[Literal["x", "y", "z"]], Field(min_length=1)] = ["x", "y", "z"]
    rate: Positive = 5.0

    @model_validator(mode="after")
    def _times_increase(self) -> ComPointSpec:
        require_increasing(self.waypoints)
        return self


class JointCouplingSpec(TaskBase):
    """A weighted sum of joint positions, `joints: {name: weight}`, has a `value`."""

    kind: Literal["joint_coupling"]
    joints: Annotated[dict[str, float], Field(min_length=1)]
    value: float = 0.0
    rate: Positive = 10.0


class DampingSpec(TaskBase):
    """What no task above asks for stands still, instead of going back to a posture."""

    kind: Literal["damping"]


class MomentumSpec(TaskBase):
    """Momentum along [N s] and about [N m s] `axes` of the world has a `value`, zero by default.

    Angular momentum is that about the centre of mass.
    """

    kind: Literal["momentum"]
    axes: Annotated[list[Literal["x", "y", "z", "rx", "ry", "rz"]], Field(min_length=1)] = [
        "rx", "ry", "rz",
    ]  # fmt: skip
    value: list[float] | None = None


class ManipulabilitySpec(TaskBase):
    """The manipulability `sqrt(det(J J^T))` of a frame stays above `least`, or is led there."""

    kind: Literal["manipulability"]
    frame: str
    least: Positive
    part: Literal["position", "rotation", "both"] = "position"
    rate: Positive = 5.0


class KeepInSpec(TaskBase):
    """A point of a frame (`offset`) stays inside the box of `size` whose middle is at `at`."""

    kind: Literal["keep_in"]
    frame: str
    at: Pose
    size: Annotated[list[Positive], Field(min_length=3, max_length=3)]
    offset: Vector3 = [0.0, 0.0, 0.0]
    rate: Positive = 5.0


class KeepOutSpec(TaskBase):
    """A point of a frame (`offset`) stays outside the ball of `radius` whose middle is at `at`."""

    kind: Literal["keep_out"]
    frame: str
    at: Pose
    radius: Positive
    offset: Vector3 = [0.0, 0.0, 0.0]
    rate: Positive = 5.0


TaskSpec = Annotated[
    HoldFrameSpec
    | FramePathSpec
    | HandOnObjectSpec
    | ComPolygonSpec
    | JointLimitsSpec
    | JointAccelerationsSpec
    | FloorSupportSpec
    | GazeSpec
    | AvoidanceSpec
    | PostureSpec
    | FrameAxesSpec
    | RelativeFrameSpec
    | ComPointSpec
    | JointCouplingSpec
    | DampingSpec
    | MomentumSpec
    | ManipulabilitySpec
    | KeepInSpec
    | KeepOutSpec,
    Field(discriminator="kind"),
]
