"""The ground of the rigid engine: a flat floor, and blocks with level tops that stand on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from equipoise.errors import InputError
from equipoise.spatial import Array

LEVEL = 1e-9  # how far the top of a block may be from level


@dataclass(frozen=True)
class Block:
    """A fixed box of `size` (3,) [m] that stands upright; feet land on its top.

    `name` is that of the body that it is a part of.
    Raises: `InputError` for a box whose top is not level.
    """

    T_world_box: pin.SE3
    size: tuple[float, float, float]
    name: str = ""

    def __post_init__(self) -> None:
        if abs(self.T_world_box.rotation[2, 2] - 1.0) > LEVEL:
            raise InputError(
                "feet of the engine rigid land on level tops alone",
                given=self.T_world_box.rotation[:, 2].tolist(),
                remedy="Stand the box upright, or use the engine mujoco",
            )

    @property
    def top(self) -> float:
        """Height [m] of its top."""
        return float(self.T_world_box.translation[2]) + 0.5 * self.size[2]

    def is_under(self, point: Array) -> bool:
        """Return whether a point (3,) [m] is over or in the block, seen from above."""
        x, y, _ = self.T_world_box.actInv(point)
        return bool(abs(x) <= 0.5 * self.size[0] and abs(y) <= 0.5 * self.size[1])


@dataclass(frozen=True)
class Ground:
    """A floor at a height [m], and blocks on it."""

    floor: float
    blocks: Sequence[Block] = ()

    def under(self, point: Array) -> float:
        """Return the height [m] of what is under a point (3,) [m]."""
        return float(np.max([self.floor, *(b.top for b in self.blocks if b.is_under(point))]))
