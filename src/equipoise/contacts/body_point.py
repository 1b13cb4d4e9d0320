"""A point fixed to a frame of the robot: where it is, and whether its offset makes sense."""

from __future__ import annotations

import numpy as np

from equipoise.kinematics import Kinematics
from equipoise.spatial import Array
from equipoise.spatial.numbers import real_array


def point_position(kin: Kinematics, frame: str | int, offset: tuple[float, float, float]) -> Array:
    """Return the position (3,) [m] in the world of the point at `offset` [m] of a frame."""
    T_world_frame = kin.placement(frame)
    return T_world_frame.translation + T_world_frame.rotation @ np.asarray(offset)


def require_offset(contact: str, offset: tuple[float, float, float]) -> None:
    """Refuse an offset that is not three finite numbers.

    Raises: `InputError`.
    """
    real_array(f"the offset of contact {contact!r}", offset, (3,))
