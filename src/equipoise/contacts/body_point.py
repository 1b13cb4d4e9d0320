"""A point fixed to a frame of the robot: position, rows, velocity and drift in world axes."""

from __future__ import annotations

import numpy as np

from equipoise.errors import InputError
from equipoise.kinematics import Kinematics
from equipoise.spatial import Array, skew

ORIGIN = (0.0, 0.0, 0.0)


def point_position(kin: Kinematics, frame_id: int, offset: tuple[float, float, float]) -> Array:
    """Return the position (3,) [m] in the world of the point at `offset` [m] of a frame."""
    T_world_frame = kin.placement(frame_id)
    return T_world_frame.translation + T_world_frame.rotation @ np.asarray(offset)


def point_jacobian(kin: Kinematics, frame_id: int, offset: tuple[float, float, float]) -> Array:
    """Return `J` (3, nv): velocity of the point in world axes."""
    J = kin.jacobian(frame_id)
    return J[:3] - skew(_lever(kin, frame_id, offset)) @ J[3:]


def point_drift(kin: Kinematics, frame_id: int, offset: tuple[float, float, float]) -> Array:
    """Return `dJ/dt v` (3,): acceleration of the point at zero `dv/dt`, in world axes."""
    lever = _lever(kin, frame_id, offset)
    omega, bias = kin.twist(frame_id)[3:], kin.drift(frame_id)
    return bias[:3] + np.cross(bias[3:], lever) + np.cross(omega, np.cross(omega, lever))


def require_offset(contact: str, offset: tuple[float, float, float]) -> None:
    """Refuse an offset that is not three finite numbers.

    Raises: `InputError`.
    """
    if len(offset) != 3 or not np.isfinite(offset).all():
        raise InputError(f"the offset of contact {contact!r} needs three numbers", given=offset)


def _lever(kin: Kinematics, frame_id: int, offset: tuple[float, float, float]) -> Array:
    return kin.placement(frame_id).rotation @ np.asarray(offset)
