"""One coloured mesh that moves with a joint."""

from __future__ import annotations

from dataclasses import dataclass

import coal
import pinocchio as pin

from equipoise.analysis.rendering.tessellation import Mesh
from equipoise.spatial import Array


@dataclass(frozen=True)
class Part:
    """A mesh in the axes of a joint, and its colour (3,) in 0..1.

    `shape` is what it was made of and `placement` where that stands in the joint's axes.
    """

    joint: int
    mesh: Mesh
    rgb: Array
    shape: coal.CollisionGeometry | None = None
    placement: pin.SE3 | None = None
