"""What is wanted over time: poses, scalars, and how much a task counts."""

from equipoise.trajectories.attached import AttachedTrajectory
from equipoise.trajectories.base import PoseSample, PoseTrajectory
from equipoise.trajectories.carried import CarriedTrajectory
from equipoise.trajectories.fade import Fade
from equipoise.trajectories.fixed import FixedPose
from equipoise.trajectories.live import LiveTarget
from equipoise.trajectories.live_scalar import LiveScalar
from equipoise.trajectories.profile import Profile
from equipoise.trajectories.pushing import PushingForce
from equipoise.trajectories.scalar import ScalarTrajectory
from equipoise.trajectories.time_scaling import MotionLimits, SlowedLeg, slow_down
from equipoise.trajectories.travel import Travel, TravelTrajectory
from equipoise.trajectories.waypoints import Waypoint, WaypointTrajectory

__all__ = [
    "AttachedTrajectory",
    "CarriedTrajectory",
    "Fade",
    "FixedPose",
    "LiveScalar",
    "LiveTarget",
    "MotionLimits",
    "PoseSample",
    "PoseTrajectory",
    "Profile",
    "PushingForce",
    "ScalarTrajectory",
    "SlowedLeg",
    "Travel",
    "TravelTrajectory",
    "Waypoint",
    "WaypointTrajectory",
    "slow_down",
]
