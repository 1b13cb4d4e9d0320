"""MuJoCo as an engine: a robot and its world generated from ours. `mujoco` is imported late."""

from equipoise.physics.mujoco.engine import MujocoEngine
from equipoise.physics.mujoco.health import EngineWarningError
from equipoise.physics.mujoco.options import MujocoOptions
from equipoise.physics.mujoco.things import LooseObject, Surroundings

__all__ = [
    "EngineWarningError",
    "LooseObject",
    "MujocoEngine",
    "MujocoOptions",
    "Surroundings",
]
