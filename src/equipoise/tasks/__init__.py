"""Tasks: each turns a kinematic state and a time into rows of a hierarchy. One file a task."""

from equipoise.tasks.avoidance import AvoidanceTask
from equipoise.tasks.base import CompiledTask, KernelTask, Task
from equipoise.tasks.com_polygon import ComPolygonTask
from equipoise.tasks.contact_rows import ContactTask
from equipoise.tasks.frame_pose import FramePoseTask
from equipoise.tasks.gaze import GazeTask
from equipoise.tasks.joint_limits import JointLimitsTask
from equipoise.tasks.posture import PostureTask
from equipoise.tasks.row_descriptions import describe_rows
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

__all__ = [
    "AttachedTrajectory",
    "AvoidanceTask",
    "ComPolygonTask",
    "CompiledTask",
    "ContactTask",
    "Fade",
    "FixedPose",
    "FramePoseTask",
    "GazeTask",
    "JointLimitsTask",
    "KernelTask",
    "PoseSample",
    "PoseTrajectory",
    "PostureTask",
    "Task",
    "TravelTrajectory",
    "Waypoint",
    "WaypointTrajectory",
    "describe_rows",
]
