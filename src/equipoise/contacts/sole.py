"""A sole: the pose of a frame is fixed in the world, six rows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from equipoise.compiled.compilation import compiled
from equipoise.compiled.scratch import scratch_matrix
from equipoise.contacts.base import WRENCH_LABELS, WRENCH_UNITS, CompiledContact
from equipoise.kinematics import Kinematics
from equipoise.kinematics.kernels import frame_motion
from equipoise.robots import Sole
from equipoise.spatial import Array, pose_row
from equipoise.spatial.kernels import crossed, rotation_difference, turned_back

FRICTION = 0.7  # coefficient between a sole and the ground, unless another is given


@dataclass(frozen=True, kw_only=True)
class SoleContact(CompiledContact):
    """The frame `frame_id` stays at `T_world_anchor`.

    Rows and wrench are written in the axes of the anchor, at the origin of the frame: with z up,
    `lam[2] >= 0` is compression.
    """

    sole: Sole
    friction: float = FRICTION
    frame_id: int
    T_world_anchor: pin.SE3

    @classmethod
    def standing(
        cls,
        sole: Sole,
        kin: Kinematics,
        *,
        name: str | None = None,
        supporting: bool = True,
        friction: float = FRICTION,
    ) -> SoleContact:
        """Return the contact of a sole that stands where it is at the state of `kin`.

        It is called as the sole is, unless a `name` is given.
        Raises: NameNotFoundError if the robot has no such frame.
        """
        frame_id = kin.robot.frame_id(sole.frame)
        return cls(
            name=sole.name if name is None else name,
            supporting=supporting,
            sole=sole,
            friction=friction,
            frame_id=frame_id,
            T_world_anchor=kin.placement(frame_id),
        )

    @property
    def labels(self) -> tuple[str, ...]:
        """Name of each row's multiplier."""
        return WRENCH_LABELS

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of each row's multiplier."""
        return WRENCH_UNITS

    kernel = "sole"

    @property
    def frames(self) -> tuple[int, int]:
        """The frame of the sole, twice."""
        return self.frame_id, self.frame_id

    @property
    def kept(self) -> Array:
        """The anchor as a pose row (12,)."""
        return pose_row(self.T_world_anchor)

    normal_row = 2

    def reaction_costs(self) -> tuple[Array, Array]:
        """Return the cost of each component: what it uses up of cone and sole.

        A tangential force counts by the normal force that its friction needs, a moment by the
        normal force that the lever of the sole needs, a yaw moment by both, all relative to the
        load that is there: a light foot can give little. A normal force counts a little, so that
        both feet carry.
        """
        half_x = 0.5 * (self.sole.x_max - self.sole.x_min)
        half_y = 0.5 * (self.sole.y_max - self.sole.y_min)
        tangential = 1.0 / self.friction
        yaw = tangential / (half_x + half_y)
        over_load = np.array([tangential, tangential, 0.0, 1.0 / half_y, 1.0 / half_x, yaw])
        return np.array([0.0, 0.0, 0.3, 0.0, 0.0, 0.0]), over_load


@compiled
def sole_rows(
    columns: np.ndarray,
    carried: np.ndarray,
    T: np.ndarray,
    anchor: np.ndarray,
    J: np.ndarray,
    residual: np.ndarray,
    at: int,
) -> None:
    """Write the rows of a frame at T and how far it is from its anchor, in axes of the anchor."""
    px, py, pz = T[9], T[10], T[11]
    for c in range(columns.shape[0]):
        if carried[c]:
            wx, wy, wz = columns[c, 3], columns[c, 4], columns[c, 5]
            lx, ly, lz = crossed(wx, wy, wz, px, py, pz)
            lx, ly, lz = lx + columns[c, 0], ly + columns[c, 1], lz + columns[c, 2]
            J[at, c], J[at + 1, c], J[at + 2, c] = turned_back(anchor, lx, ly, lz)
            J[at + 3, c], J[at + 4, c], J[at + 5, c] = turned_back(anchor, wx, wy, wz)
        else:
            for i in range(6):
                J[at + i, c] = 0.0
    dx, dy, dz = px - anchor[9], py - anchor[10], pz - anchor[11]
    residual[at], residual[at + 1], residual[at + 2] = turned_back(anchor, dx, dy, dz)
    rx, ry, rz = rotation_difference(T, anchor)
    residual[at + 3], residual[at + 4], residual[at + 5] = turned_back(anchor, rx, ry, rz)


@compiled
def sole_drift(
    joint: np.ndarray,
    velocity: np.ndarray,
    acceleration: np.ndarray,
    T: np.ndarray,
    anchor: np.ndarray,
    drift: np.ndarray,
    at: int,
) -> None:
    """Write `dJ/dt v` in axes of the anchor."""
    motion = scratch_matrix(2, 6)
    frame_motion(joint, velocity, acceleration, T, motion)
    a = motion[1]
    drift[at], drift[at + 1], drift[at + 2] = turned_back(anchor, a[0], a[1], a[2])
    drift[at + 3], drift[at + 4], drift[at + 5] = turned_back(anchor, a[3], a[4], a[5])
