"""The only SE(3)/SO(3) algebra of ours: thin functions over Pinocchio.

Conventions: `T_a_b` maps coordinates in b to coordinates in a; a twist is (linear, angular).
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.integer[Any]]
Mask = NDArray[np.bool_]
POSE_SIZE, TWIST_SIZE = 7, 6  # numbers of a pose (position, quaternion xyzw) and of a twist


def pose_row(T: pin.SE3) -> Array:
    """Return a pose as kernels read it (12,): rotation column by column, then translation."""
    return np.concatenate((T.rotation.T.ravel(), T.translation))


def skew(p: Array) -> Array:
    """Return [p x], the (3, 3) matrix with [p x] y = p x y."""
    return pin.skew(p)


def velocity_transport(q: Array, q_ref: Array, v_ref: Array) -> Array:
    """Express a reference velocity in the base axes of the actual configuration.

    Args: `q`, `q_ref` (nq,) free-flyer configurations; `v_ref` (nv,), its first six entries the
    base twist in base axes of `q_ref`. Returns `Ad v_ref` (nv,): the same motion of the base as
    seen from the base frame of `q`, so that `v - Ad v_ref` compares like with like.
    """
    T_world_base = pin.XYZQUATToSE3(q[:POSE_SIZE])
    T_world_ref = pin.XYZQUATToSE3(q_ref[:POSE_SIZE])
    v = v_ref.copy()
    twist = T_world_base.actInv(T_world_ref).act(pin.Motion(v_ref[:TWIST_SIZE]))
    v[:TWIST_SIZE] = twist.vector
    return v
