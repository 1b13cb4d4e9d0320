"""A surface contact: a point of the robot slides without friction on a smooth surface, one row."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin

from equipoise.contacts.sliding import SlidingContact
from equipoise.spatial import Array, pose_row
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

    def place(self, t: float) -> Array:
        """Return the pose row of the surface, and that it does not move (24,)."""
        return np.concatenate((pose_row(self.T_world_surface), np.zeros(12)))
