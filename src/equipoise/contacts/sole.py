"""A sole: the pose of a frame is fixed in the world, six rows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from equipoise.contacts.base import WRENCH_LABELS, WRENCH_UNITS, Contact
from equipoise.kinematics import Kinematics
from equipoise.robots import Sole
from equipoise.spatial import Array, pose_error


@dataclass(frozen=True, kw_only=True)
class SoleContact(Contact):
    """The frame `frame_id` stays at `T_world_anchor`.

    Rows and wrench are written in the axes of the anchor, at the origin of the frame: with z up,
    `lam[2] >= 0` is compression.
    """

    sole: Sole
    friction: float = 0.7
    frame_id: int
    T_world_anchor: pin.SE3

    @property
    def labels(self) -> tuple[str, ...]:
        """Name of each row's multiplier."""
        return WRENCH_LABELS

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of each row's multiplier."""
        return WRENCH_UNITS

    def jacobian(self, kin: Kinematics) -> Array:
        """Return `J` (6, nv)."""
        return self._to_anchor(kin.jacobian(self.frame_id))

    def drift(self, kin: Kinematics) -> Array:
        """Return `dJ/dt v` (6,)."""
        return self._to_anchor(kin.drift(self.frame_id))

    def residual(self, kin: Kinematics) -> Array:
        """Return `phi` (6,): position [m] and rotation vector [rad] relative to the anchor."""
        return -self._to_anchor(pose_error(self.T_world_anchor, kin.placement(self.frame_id)))

    def normal_force(self, lam: Array) -> float:
        """Return the compression [N] in a multiplier `lam` (6,)."""
        return float(lam[2])

    def reaction_costs(self, load: float) -> Array:
        """Return the cost (6,) of each component: what it uses up of cone and sole.

        A tangential force counts by the normal force that its friction needs, a moment by the
        normal force that the lever of the sole needs, a yaw moment by both, all relative to the
        load that is there: a light foot can give little. A normal force counts a little, so that
        both feet carry.
        """
        half_x = 0.5 * (self.sole.x_max - self.sole.x_min)
        half_y = 0.5 * (self.sole.y_max - self.sole.y_min)
        tangential = 1.0 / (load * self.friction)
        yaw = tangential / (half_x + half_y)
        pitch, roll = 1.0 / (load * half_x), 1.0 / (load * half_y)
        return np.array([tangential, tangential, 0.3, roll, pitch, yaw])

    def __post_init__(self) -> None:
        super().__post_init__()
        turn = np.kron(np.eye(2), self.T_world_anchor.rotation.T)
        object.__setattr__(self, "_turn", turn)

    def _to_anchor(self, world: Array) -> Array:
        """Turn the two halves of `world` (6,) or (6, k) into the axes of the anchor."""
        return self._turn @ world
