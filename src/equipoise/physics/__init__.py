"""Physics engines. None of them knows a controller."""

from equipoise.physics.engine import DivergedError, PhysicsEngine, PhysicsState
from equipoise.physics.pushed_object import PushedObject, PushedObjectMode, PushedObjectState
from equipoise.physics.rigid.engine import RigidContactEngine, RigidOptions

__all__ = [
    "DivergedError",
    "PhysicsEngine",
    "PhysicsState",
    "PushedObject",
    "PushedObjectMode",
    "PushedObjectState",
    "RigidContactEngine",
    "RigidOptions",
]
