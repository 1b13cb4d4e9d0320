"""A surface contact: a point of the robot slides without friction on a smooth surface, one row."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin

from equipoise.contacts.base import ORIGIN
from equipoise.contacts.body_point import point_position
from equipoise.contacts.sliding import SlidingContact
from equipoise.contacts.surfaces.plane import Plane
from equipoise.errors import InputError
from equipoise.kinematics import Kinematics
from equipoise.spatial import Array, pose_row
from equipoise.spatial.numbers import real_array
from equipoise.spatial.poses import rigid


@dataclass(frozen=True, kw_only=True)
class SurfaceContact(SlidingContact):
    """The point `offset` [m] of `frame` stays on a surface at rest at `T_world_surface`.

    Row, multiplier and source as in `SlidingContact`.
    """

    T_world_surface: pin.SE3 = field(default_factory=pin.SE3.Identity)

    def __post_init__(self) -> None:
        super().__post_init__()
        rigid(f"the surface of contact {self.name!r}", self.T_world_surface)

    @classmethod
    def on_plane(
        cls,
        name: str,
        frame: str | int,
        kin: Kinematics,
        normal: Sequence[float] | Array,
        *,
        offset: tuple[float, float, float] = ORIGIN,
    ) -> SurfaceContact:
        """Return the contact with a plane through the point `offset` [m] of `frame` at `kin`.

        `normal` (3,) of any length points out of the wall or table to the robot, in world axes; the
        pressure along it is regulated. Raises: `InputError`, `NameNotFoundError`, `ShapeError`.
        """
        n = real_array(f"the normal of contact {name!r}", normal, (3,))
        if not np.linalg.norm(n) > 0.0:
            raise InputError(f"the normal of contact {name!r} must not be zero", given=n.tolist())
        turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), n / np.linalg.norm(n))
        at = point_position(kin, frame, offset)
        return cls(
            name=name,
            regulated=("fn",),
            frame=frame,
            surface=Plane(),
            offset=offset,
            T_world_surface=pin.SE3(turn.toRotationMatrix(), at),
        )

    def place(self, t: float) -> Array:
        """Return the pose row of the surface, and that it does not move (24,)."""
        return np.concatenate((pose_row(self.T_world_surface), np.zeros(12)))
