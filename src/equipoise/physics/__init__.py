"""Physics engines. None of them knows a controller."""

from equipoise.physics.engine import PhysicsEngine, PhysicsState
from equipoise.physics.faults import FaultInjector, Faults, Push
from equipoise.physics.rigid import DivergedError, RigidContactEngine
from equipoise.physics.sensors import Reading, SensorModel, SensorModels, SensorSuite, Silence
from equipoise.physics.slider import Slider, SliderMode, SliderState

__all__ = [
    "DivergedError",
    "FaultInjector",
    "Faults",
    "PhysicsEngine",
    "PhysicsState",
    "Push",
    "Reading",
    "RigidContactEngine",
    "SensorModel",
    "SensorModels",
    "SensorSuite",
    "Silence",
    "Slider",
    "SliderMode",
    "SliderState",
]
