"""What is wanted over time: poses, scalars, and how much a task counts."""

from equipoise.trajectories.fade import Fade
from equipoise.trajectories.poses import (
    AttachedTrajectory,
    FixedPose,
    PoseSample,
    PoseTrajectory,
    TravelTrajectory,
    Waypoint,
    WaypointTrajectory,
)
from equipoise.trajectories.profile import Profile

__all__ = [
    "AttachedTrajectory",
    "Fade",
    "FixedPose",
    "PoseSample",
    "PoseTrajectory",
    "Profile",
    "TravelTrajectory",
    "Waypoint",
    "WaypointTrajectory",
]
