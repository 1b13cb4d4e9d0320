"""A surface contact: a point of the robot slides without friction on a smooth surface, one row."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin

from equipoise.contacts.base import Contact
from equipoise.contacts.body_point import (
    ORIGIN,
    point_drift,
    point_jacobian,
    point_position,
    require_offset,
)
from equipoise.contacts.surfaces import Surface
from equipoise.kinematics import Kinematics
from equipoise.spatial import Array


@dataclass(frozen=True, kw_only=True)
class SurfaceContact(Contact):
    """The point `offset` [m] of frame `frame_id` stays on a surface at rest at `T_world_surface`.

    The row is `n . velocity` with the unit normal n out of the object toward the robot, so that
    the multiplier is the normal force [N], compression positive.
    Source: eq. (13) and the rows below it. Differs from the print: `J_phix` is divided by
    `|grad phi|`, and with it the multiplier becomes a force in newtons for any phi.
    """

    frame_id: int
    surface: Surface
    T_world_surface: pin.SE3 = field(default_factory=pin.SE3.Identity)
    offset: tuple[float, float, float] = ORIGIN

    def __post_init__(self) -> None:
        super().__post_init__()
        require_offset(self.name, self.offset)

    @property
    def labels(self) -> tuple[str, ...]:
        """Name of the multiplier."""
        return ("fn",)

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of the multiplier."""
        return ("N",)

    def position(self, kin: Kinematics) -> Array:
        """Return where the contact point is in the world (3,) [m]."""
        return point_position(kin, self.frame_id, self.offset)

    def normal(self, kin: Kinematics) -> Array:
        """Return the unit normal (3,) in world axes, out of the object toward the robot."""
        x = self.T_world_surface.actInv(self.position(kin))
        return self.T_world_surface.rotation @ self.surface.normal(x)

    def jacobian(self, kin: Kinematics) -> Array:
        """Return `J` (1, nv): speed along the normal."""
        return (self.normal(kin) @ point_jacobian(kin, self.frame_id, self.offset))[None]

    def drift(self, kin: Kinematics) -> Array:
        """Return `dJ/dt v` (1,): bias along the normal, and the normal turning as the point moves.

        `dn/dt = (I - n n^T) Hess xdot / |grad|`, of which xdot sees the curvature.
        """
        R = self.T_world_surface.rotation
        x = self.T_world_surface.actInv(self.position(kin))
        xdot = R.T @ (point_jacobian(kin, self.frame_id, self.offset) @ kin.v)
        bias = R.T @ point_drift(kin, self.frame_id, self.offset)
        n, steepness = self.surface.normal(x), self.surface.steepness(x)
        bent = self.surface.hessian(x) @ xdot / steepness
        turning = bent - n * (n @ bent)
        return np.array([n @ bias + turning @ xdot])

    def residual(self, kin: Kinematics) -> Array:
        """Return `phi / |grad phi|` (1,) [m]: the distance to first order, positive outside."""
        return np.array([self.surface.distance(self.T_world_surface.actInv(self.position(kin)))])
