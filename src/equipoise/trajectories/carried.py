"""A path told in the axes of a body that itself moves: what is carried along."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from equipoise.compiled import entrance
from equipoise.spatial import Array
from equipoise.spatial.kernels import compose, crossed, turned
from equipoise.trajectories.base import (
    GIVEN,
    ROW,
    PoseSample,
    PoseTrajectory,
    require_trajectory,
)


@dataclass(frozen=True)
class CarriedTrajectory(PoseTrajectory):
    """The `path` of a frame in the axes of a `carrier`, both of which move.

    Raises: `InputError` for what is no trajectory.
    """

    carrier: PoseTrajectory
    path: PoseTrajectory
    kind = GIVEN

    def __post_init__(self) -> None:
        require_trajectory("the carrier of a CarriedTrajectory", self.carrier)
        require_trajectory("the path of a CarriedTrajectory", self.path)

    def row(self, t: float) -> Array:
        """Return pose row and twist (18,) in the world at time `t` [s]."""
        row = np.empty(ROW)
        carried_alone(self.carrier.row(t), self.path.row(t), row)
        return row

    def at(self, t: float) -> PoseSample:
        """Return the pose and its rate at time `t` [s]."""
        row = self.row(t)
        T = pin.SE3(row[:9].reshape(3, 3).T.copy(), row[9:12].copy())
        return PoseSample(T, row[12:].copy())


@entrance
def carried_alone(carrier: np.ndarray, path: np.ndarray, row: np.ndarray) -> None:
    """Write pose row and twist [18] of a frame that moves in the axes of a moving carrier."""
    compose(carrier, path, row)
    rx, ry, rz = row[9] - carrier[9], row[10] - carrier[10], row[11] - carrier[11]
    cx, cy, cz = crossed(carrier[15], carrier[16], carrier[17], rx, ry, rz)
    vx, vy, vz = turned(carrier, path[12], path[13], path[14])
    wx, wy, wz = turned(carrier, path[15], path[16], path[17])
    row[12], row[13], row[14] = (
        carrier[12] + cx + vx,
        carrier[13] + cy + vy,
        carrier[14] + cz + vz,
    )
    row[15], row[16], row[17] = carrier[15] + wx, carrier[16] + wy, carrier[17] + wz
