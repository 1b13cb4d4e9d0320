"""The schema of a scenario file: every key, its type, its default, its meaning. One file a section.

Lengths are in metres, angles in radians, times in seconds, forces in newtons.
"""

from equipoise.scenarios.schema.acceptance import (
    AcceptanceSpec,
    Limit,
)
from equipoise.scenarios.schema.base import (
    Colour,
    Name,
    NotNegative,
    Pose,
    Positive,
    Section,
    ShapeSpec,
    Vector3,
)
from equipoise.scenarios.schema.contacts import (
    ContactSpec,
    FootContactSpec,
    ForceProfile,
    GraspContactSpec,
    PushContactSpec,
    SoleContactSpec,
    SurfaceContactSpec,
    SurfaceSpec,
)
from equipoise.scenarios.schema.control import (
    ControlSpec,
    GainsSpec,
    GovernorSpec,
    SignSpec,
)
from equipoise.scenarios.schema.disturbances import (
    DisturbancesSpec,
    ExternalForceSpec,
    FaultsSpec,
    LinkScaleSpec,
    PayloadSpec,
    SensorSpec,
    SensorsSpec,
    SilenceSpec,
)
from equipoise.scenarios.schema.physics import (
    MujocoSpec,
    PhysicsSpec,
)
from equipoise.scenarios.schema.scenario import (
    Scenario,
)
from equipoise.scenarios.schema.tasks import (
    AvoidanceSpec,
    ComPolygonSpec,
    FloorSupportSpec,
    FramePathSpec,
    GazeSpec,
    HandOnObjectSpec,
    HoldFrameSpec,
    JointAccelerationsSpec,
    JointLimitsSpec,
    PostureSpec,
    TaskBase,
    TaskSpec,
)
from equipoise.scenarios.schema.world import (
    FixedBody,
    HeldObject,
    SliderSpec,
    TravelSpec,
    WaypointSpec,
    WorldSpec,
)

__all__ = [
    "AcceptanceSpec",
    "AvoidanceSpec",
    "Colour",
    "ComPolygonSpec",
    "ContactSpec",
    "ControlSpec",
    "DisturbancesSpec",
    "ExternalForceSpec",
    "FaultsSpec",
    "FixedBody",
    "FloorSupportSpec",
    "FootContactSpec",
    "ForceProfile",
    "FramePathSpec",
    "GainsSpec",
    "GazeSpec",
    "GovernorSpec",
    "GraspContactSpec",
    "HandOnObjectSpec",
    "HeldObject",
    "HoldFrameSpec",
    "JointAccelerationsSpec",
    "JointLimitsSpec",
    "Limit",
    "LinkScaleSpec",
    "MujocoSpec",
    "Name",
    "NotNegative",
    "PayloadSpec",
    "PhysicsSpec",
    "Pose",
    "Positive",
    "PostureSpec",
    "PushContactSpec",
    "Scenario",
    "Section",
    "SensorSpec",
    "SensorsSpec",
    "ShapeSpec",
    "SignSpec",
    "SilenceSpec",
    "SliderSpec",
    "SoleContactSpec",
    "SurfaceContactSpec",
    "SurfaceSpec",
    "TaskBase",
    "TaskSpec",
    "TravelSpec",
    "Vector3",
    "WaypointSpec",
    "WorldSpec",
]
