"""Tasks: each turns a kinematic state and a time into rows of a hierarchy. One file a task."""

from equipoise.renamed import old_names_of
from equipoise.tasks.avoidance import AvoidanceTask
from equipoise.tasks.base import AimedTask, KernelTask, Task, describe_rows
from equipoise.tasks.com_point import ComTask
from equipoise.tasks.com_polygon import ComPolygonTask
from equipoise.tasks.contact_rows import ContactTask
from equipoise.tasks.coupling import JointCouplingTask
from equipoise.tasks.damping import DampingTask
from equipoise.tasks.floor_support import FloorSupportTask
from equipoise.tasks.frame_axes import FrameAxesTask
from equipoise.tasks.frame_pose import FramePoseTask
from equipoise.tasks.gaze import GazeTask
from equipoise.tasks.joint_accelerations import JointAccelerationsTask
from equipoise.tasks.joint_limits import JointLimitsTask
from equipoise.tasks.manipulability import ManipulabilityTask
from equipoise.tasks.momentum import MomentumTask
from equipoise.tasks.posture import PostureTask
from equipoise.tasks.reach import Reach
from equipoise.tasks.relative_frame import RelativeFrameTask
from equipoise.tasks.volumes import KeepInTask, KeepOutTask

__all__ = [
    "AimedTask",
    "AvoidanceTask",
    "ComPolygonTask",
    "ComTask",
    "ContactTask",
    "DampingTask",
    "FloorSupportTask",
    "FrameAxesTask",
    "FramePoseTask",
    "GazeTask",
    "JointAccelerationsTask",
    "JointCouplingTask",
    "JointLimitsTask",
    "KeepInTask",
    "KeepOutTask",
    "KernelTask",
    "ManipulabilityTask",
    "MomentumTask",
    "PostureTask",
    "Reach",
    "RelativeFrameTask",
    "Task",
    "describe_rows",
]

__getattr__ = old_names_of(__name__)
