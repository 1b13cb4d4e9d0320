"""A frame that rides on a moving body."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pinocchio as pin

from equipoise.compiled import compiled, entrance
from equipoise.spatial import Array, pose_row
from equipoise.spatial.kernels import compose, crossed
from equipoise.spatial.poses import rigid
from equipoise.trajectories.base import (
    ATTACHED,
    ROW,
    CompiledTrajectory,
    PoseTrajectory,
    require_trajectory,
)


@dataclass(frozen=True)
class AttachedTrajectory(CompiledTrajectory):
    """A frame rigidly attached to a moving `body`, at `T_body_frame`.

    Raises: `InputError` for a body or a pose that is none.
    """

    body: PoseTrajectory
    T_body_frame: pin.SE3
    kind = ATTACHED

    def __post_init__(self) -> None:
        require_trajectory("the body of an AttachedTrajectory", self.body)
        rigid("the pose of an attached frame", self.T_body_frame)

    @cached_property
    def numbers(self) -> Array:
        """The pose row of the frame in the body (12,)."""
        return pose_row(self.T_body_frame)

    @property
    def rides_on(self) -> PoseTrajectory:
        """The body."""
        return self.body

    def row(self, t: float) -> Array:
        """Return pose row and twist (18,) of the attached frame at time `t` [s]."""
        row = np.empty(ROW)
        attached_alone(self.body.row(t), self.numbers, row)
        return row


@compiled
def attached_row(body: np.ndarray, attached: np.ndarray, row: np.ndarray) -> None:
    """Write pose row and twist [18] of a frame at `attached` [12] on a moving body."""
    compose(body, attached, row)
    rx, ry, rz = row[9] - body[9], row[10] - body[10], row[11] - body[11]
    cx, cy, cz = crossed(body[15], body[16], body[17], rx, ry, rz)
    row[12], row[13], row[14] = body[12] + cx, body[13] + cy, body[14] + cz
    row[15], row[16], row[17] = body[15], body[16], body[17]


@entrance
def attached_alone(body: np.ndarray, attached: np.ndarray, row: np.ndarray) -> None:
    """Write the row of one attached frame."""
    attached_row(body, attached, row)
