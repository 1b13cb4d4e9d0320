"""Motion generation: tasks and contacts in, posture and velocity references out."""

from equipoise.motion.acceleration_advice import (
    AccelerationAdvice,
    advise_accelerations,
    borne_inertia,
)
from equipoise.motion.generator import MotionGenerator, MotionStep, StaleMotionError
from equipoise.motion.governor import Governor
from equipoise.motion.inverse_kinematics import InverseKinematics
from equipoise.motion.posture import PostureNotFoundError, solve_posture
from equipoise.motion.reaching import live_reach

__all__ = [
    "AccelerationAdvice",
    "Governor",
    "InverseKinematics",
    "MotionGenerator",
    "MotionStep",
    "PostureNotFoundError",
    "StaleMotionError",
    "advise_accelerations",
    "borne_inertia",
    "live_reach",
    "solve_posture",
]
