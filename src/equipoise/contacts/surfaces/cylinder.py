"""An infinite cylinder about the z axis of its own coordinates."""

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

_ACROSS = np.diag([1.0, 1.0, 0.0])


@dataclass(frozen=True)
class Cylinder(Surface):
    """`phi = sqrt(x^2 + y^2) - radius`, the distance; it has no normal on the axis."""

    radius: float

    def __post_init__(self) -> None:
        require_length("cylinder", "radius", self.radius)

    def value(self, x: Array) -> float:
        """Return phi at `x` (3,)."""
        return float(np.hypot(x[0], x[1])) - self.radius

    def gradient(self, x: Array) -> Array:
        """Return the gradient (3,)."""
        return _ACROSS @ x / self._length(x)

    def hessian(self, x: Array) -> Array:
        """Return the Hessian (3, 3)."""
        length = self._length(x)
        return distance_hessian(_ACROSS @ x / length, _ACROSS, length)

    def _length(self, x: Array) -> float:
        length = float(np.hypot(x[0], x[1]))
        if length < 1e-9 * self.radius:
            raise VanishingGradientError(self.name, x)
        return length
