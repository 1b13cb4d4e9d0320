"""The plane z = 0 of its own coordinates, the robot on the side of positive z."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from equipoise.contacts.surfaces.base import Surface
from equipoise.spatial import Array


@dataclass(frozen=True)
class Plane(Surface):
    """`phi = z`, the distance."""

    def value(self, x: Array) -> float:
        """Return phi at `x` (3,)."""
        return float(x[2])

    def gradient(self, x: Array) -> Array:
        """Return the gradient (3,)."""
        return np.array([0.0, 0.0, 1.0])

    def hessian(self, x: Array) -> Array:
        """Return the Hessian (3, 3), which is zero."""
        return np.zeros((3, 3))
