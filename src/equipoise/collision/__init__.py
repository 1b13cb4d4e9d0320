"""Bodies around the robot, and the distances between them."""

from equipoise.collision.distances import DistanceEvaluator, PairDistance
from equipoise.collision.scene import Body, Pair, Scene, Shape

__all__ = ["Body", "DistanceEvaluator", "Pair", "PairDistance", "Scene", "Shape"]
