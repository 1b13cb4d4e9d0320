"""SE(3) and SO(3): thin functions over Pinocchio, their kernels, rotation parameters."""

from equipoise.spatial.hull import convex_hull
from equipoise.spatial.poses import pose
from equipoise.spatial.se3 import (
    POSE_SIZE,
    TWIST_SIZE,
    Array,
    Indices,
    Mask,
    pose_row,
    skew,
    velocity_transport,
)

__all__ = [
    "POSE_SIZE",
    "TWIST_SIZE",
    "Array",
    "Indices",
    "Mask",
    "convex_hull",
    "pose",
    "pose_row",
    "skew",
    "velocity_transport",
]
