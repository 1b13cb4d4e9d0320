"""Physics engines. None of them knows a controller."""

from equipoise.physics.engine import DivergedError, PhysicsEngine, PhysicsState
from equipoise.physics.pushed_object import PushedObject, PushedObjectMode, PushedObjectState
from equipoise.physics.rigid.engine import RigidContactEngine, RigidOptions
from equipoise.physics.rigid.unilateral import ContactEvent, UnilateralContactEngine

__all__ = [
    "ContactEvent",
    "DivergedError",
    "PhysicsEngine",
    "PhysicsState",
    "PushedObject",
    "PushedObjectMode",
    "PushedObjectState",
    "RigidContactEngine",
    "RigidOptions",
    "UnilateralContactEngine",
]
