"""Motion generation: tasks and contacts in, posture and velocity references out."""

from equipoise.motion.generator import MotionGenerator, MotionStep, StaleMotionError
from equipoise.motion.inverse_kinematics import InverseKinematics
from equipoise.motion.posture import PostureNotFoundError, solve_posture

__all__ = [
    "InverseKinematics",
    "MotionGenerator",
    "MotionStep",
    "PostureNotFoundError",
    "StaleMotionError",
    "solve_posture",
]
