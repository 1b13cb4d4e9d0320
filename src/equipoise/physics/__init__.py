"""Physics engines. None of them knows a controller."""

from equipoise.physics.engine import PhysicsEngine, PhysicsState
from equipoise.physics.rigid import DivergedError, RigidContactEngine
from equipoise.physics.slider import Slider, SliderMode, SliderState

__all__ = [
    "DivergedError",
    "PhysicsEngine",
    "PhysicsState",
    "RigidContactEngine",
    "Slider",
    "SliderMode",
    "SliderState",
]
