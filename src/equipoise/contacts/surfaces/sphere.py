"""A sphere about the origin of its own coordinates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from equipoise.contacts.surfaces.base import (
    Surface,
    VanishingGradientError,
    distance_hessian,
    require_length,
)
from equipoise.spatial import Array


@dataclass(frozen=True)
class Sphere(Surface):
    """`phi = |x| - radius`, the distance; it has no normal at the centre."""

    radius: float

    def __post_init__(self) -> None:
        require_length("sphere", "radius", self.radius)

    def value(self, x: Array) -> float:
        """Return phi at `x` (3,)."""
        return float(np.linalg.norm(x)) - self.radius

    def gradient(self, x: Array) -> Array:
        """Return the gradient (3,)."""
        return x / self._length(x)

    def hessian(self, x: Array) -> Array:
        """Return the Hessian (3, 3)."""
        length = self._length(x)
        return distance_hessian(x / length, np.eye(3), length)

    def _length(self, x: Array) -> float:
        length = float(np.linalg.norm(x))
        if length < 1e-9 * self.radius:
            raise VanishingGradientError(self.name, x)
        return length
