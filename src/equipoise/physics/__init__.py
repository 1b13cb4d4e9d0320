"""Physics engines. None of them knows a controller."""

from equipoise.physics.engine import PhysicsEngine, PhysicsState
from equipoise.physics.pushed_object import PushedObject, PushedObjectMode, PushedObjectState
from equipoise.physics.rigid.engine import DivergedError, RigidContactEngine

__all__ = [
    "DivergedError",
    "PhysicsEngine",
    "PhysicsState",
    "PushedObject",
    "PushedObjectMode",
    "PushedObjectState",
    "RigidContactEngine",
]
