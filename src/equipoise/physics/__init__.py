"""Physics engines. None of them knows a controller."""

from equipoise.physics.engine import PhysicsEngine, PhysicsState
from equipoise.physics.rigid import RigidContactEngine

__all__ = ["PhysicsEngine", "PhysicsState", "RigidContactEngine"]
