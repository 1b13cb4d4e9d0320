"""A pose that does not move."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pinocchio as pin

from equipoise.spatial import Array, pose_row
from equipoise.spatial.poses import rigid
from equipoise.trajectories.base import FIXED, CompiledTrajectory, instant


@dataclass(frozen=True)
class FixedPose(CompiledTrajectory):
    """The pose `T_world_target` at any time.

    Raises: `InputError` for a pose that is none.
    """

    T_world_target: pin.SE3
    kind = FIXED

    def __post_init__(self) -> None:
        rigid("the pose of a FixedPose", self.T_world_target)

    @cached_property
    def numbers(self) -> Array:
        """The row itself (18,)."""
        return np.concatenate((pose_row(self.T_world_target), np.zeros(6)))

    def row(self, t: float) -> Array:
        """Return the same row (18,) at any time."""
        instant(t)
        return self.numbers.copy()
