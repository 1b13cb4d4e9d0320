"""MuJoCo as an engine: a robot and its world generated from ours. `mujoco` is imported late."""

from equipoise.physics.mujoco.engine import MujocoEngine
from equipoise.physics.mujoco.health import EngineWarningError
from equipoise.physics.mujoco.objects import LooseObject, Surroundings
from equipoise.physics.mujoco.options import MujocoOptions

__all__ = [
    "EngineWarningError",
    "LooseObject",
    "MujocoEngine",
    "MujocoOptions",
    "Surroundings",
]
