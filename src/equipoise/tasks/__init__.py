"""Tasks: each turns a kinematic state and a time into rows of a hierarchy. One file a task."""

from equipoise.renamed import old_names_of
from equipoise.tasks.avoidance import AvoidanceTask
from equipoise.tasks.base import KernelTask, Task, describe_rows
from equipoise.tasks.com_polygon import ComPolygonTask
from equipoise.tasks.contact_rows import ContactTask
from equipoise.tasks.floor_support import FloorSupportTask
from equipoise.tasks.frame_pose import FramePoseTask
from equipoise.tasks.gaze import GazeTask
from equipoise.tasks.joint_accelerations import JointAccelerationsTask
from equipoise.tasks.joint_limits import JointLimitsTask
from equipoise.tasks.posture import PostureTask

__all__ = [
    "AvoidanceTask",
    "ComPolygonTask",
    "ContactTask",
    "FloorSupportTask",
    "FramePoseTask",
    "GazeTask",
    "JointAccelerationsTask",
    "JointLimitsTask",
    "KernelTask",
    "PostureTask",
    "Task",
    "describe_rows",
]

__getattr__ = old_names_of(__name__)
