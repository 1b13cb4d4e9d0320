"""SE(3) and SO(3): thin functions over Pinocchio, their kernels, rotation parameters."""

from equipoise.spatial.se3 import Array, pose, pose_row, skew, velocity_transport

__all__ = ["Array", "pose", "pose_row", "skew", "velocity_transport"]
