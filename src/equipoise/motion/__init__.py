"""Motion generation: tasks and contacts in, posture and velocity references out."""

from equipoise.motion.fading import Fading, FadingGenerator
from equipoise.motion.generator import MotionGenerator, MotionStep
from equipoise.motion.posture import PostureNotFoundError, solve_posture

__all__ = [
    "Fading",
    "FadingGenerator",
    "MotionGenerator",
    "MotionStep",
    "PostureNotFoundError",
    "solve_posture",
]
