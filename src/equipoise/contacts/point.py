"""A point contact: a point of a frame stays where it is in the world, three rows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from equipoise.compiled.compilation import compiled
from equipoise.compiled.scratch import scratch, scratch_matrix
from equipoise.contacts.base import WRENCH_LABELS, WRENCH_UNITS, CompiledContact
from equipoise.contacts.body_point import ORIGIN, require_offset
from equipoise.errors import ShapeError
from equipoise.kinematics.kernels import frame_motion
from equipoise.spatial import Array
from equipoise.spatial.kernels import crossed, turned


@dataclass(frozen=True, kw_only=True)
class PointContact(CompiledContact):
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

    kernel = "point"

    @property
    def frames(self) -> tuple[int, int]:
        """The frame of the point, twice."""
        return self.frame_id, self.frame_id

    @property
    def kept(self) -> Array:
        """The offset and where it stays, filled up to (12,)."""
        return np.concatenate((self.offset, self.p_world, np.zeros(6)))


@compiled
def point_rows(
    columns: np.ndarray,
    carried: np.ndarray,
    T: np.ndarray,
    kept: np.ndarray,
    J: np.ndarray,
    residual: np.ndarray,
    at: int,
) -> None:
    """Write the velocity of a point of a frame at T, and how far it is from its place."""
    rx, ry, rz = turned(T, kept[0], kept[1], kept[2])
    px, py, pz = T[9] + rx, T[10] + ry, T[11] + rz
    for c in range(columns.shape[0]):
        x, y, z = crossed(columns[c, 3], columns[c, 4], columns[c, 5], px, py, pz)
        J[at, c] = carried[c] * (columns[c, 0] + x)
        J[at + 1, c] = carried[c] * (columns[c, 1] + y)
        J[at + 2, c] = carried[c] * (columns[c, 2] + z)
    residual[at], residual[at + 1], residual[at + 2] = px - kept[3], py - kept[4], pz - kept[5]


@compiled
def point_drift_rows(
    joint: np.ndarray,
    velocity: np.ndarray,
    acceleration: np.ndarray,
    T: np.ndarray,
    kept: np.ndarray,
    drift: np.ndarray,
    at: int,
) -> None:
    """Write `dJ/dt v`: the acceleration of the point at zero `dv/dt`."""
    there, motion = scratch(12), scratch_matrix(2, 6)
    rx, ry, rz = turned(T, kept[0], kept[1], kept[2])
    for i in range(9):
        there[i] = T[i]
    there[9], there[10], there[11] = T[9] + rx, T[10] + ry, T[11] + rz
    frame_motion(joint, velocity, acceleration, there, motion)
    drift[at], drift[at + 1], drift[at + 2] = motion[1, 0], motion[1, 1], motion[1, 2]
