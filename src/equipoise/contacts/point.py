"""A point contact: a point of a frame stays where it is in the world, three rows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from equipoise.contacts.base import WRENCH_LABELS, WRENCH_UNITS, Contact
from equipoise.contacts.body_point import (
    ORIGIN,
    point_drift,
    point_jacobian,
    point_position,
    require_offset,
)
from equipoise.errors import ShapeError
from equipoise.kinematics import Kinematics
from equipoise.spatial import Array


@dataclass(frozen=True, kw_only=True)
class PointContact(Contact):
    """The point `offset` [m] of frame `frame_id` stays at `p_world` (3,) [m].

    Rows and force are in world axes; the frame may turn about the point.
    """

    frame_id: int
    p_world: Array
    offset: tuple[float, float, float] = ORIGIN

    def __post_init__(self) -> None:
        super().__post_init__()
        require_offset(self.name, self.offset)
        if np.shape(self.p_world) != (3,):
            raise ShapeError(f"p_world of contact {self.name!r}", np.shape(self.p_world), (3,))

    @property
    def labels(self) -> tuple[str, ...]:
        """Name of each row's multiplier."""
        return WRENCH_LABELS[:3]

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of each row's multiplier."""
        return WRENCH_UNITS[:3]

    def jacobian(self, kin: Kinematics) -> Array:
        """Return `J` (3, nv)."""
        return point_jacobian(kin, self.frame_id, self.offset)

    def drift(self, kin: Kinematics) -> Array:
        """Return `dJ/dt v` (3,)."""
        return point_drift(kin, self.frame_id, self.offset)

    def residual(self, kin: Kinematics) -> Array:
        """Return `phi` (3,) [m]: where the point is, from where it should be."""
        return point_position(kin, self.frame_id, self.offset) - self.p_world
