"""An ellipsoid about the origin, its axes along those of its own coordinates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from equipoise.contacts.surfaces.base import Surface, require_length
from equipoise.errors import ShapeError
from equipoise.spatial import Array


@dataclass(frozen=True)
class Ellipsoid(Surface):
    """`phi = (sum (x_i / a_i)^2 - 1) / 2` with semi-axes `a` (3,) [m]; not a distance."""

    semi_axes: tuple[float, float, float]

    def __post_init__(self) -> None:
        if len(self.semi_axes) != 3:
            raise ShapeError("semi_axes of an ellipsoid", (len(self.semi_axes),), (3,))
        for length in self.semi_axes:
            require_length("ellipsoid", "semi-axis", length)

    @property
    def _curvatures(self) -> Array:
        return 1.0 / np.square(self.semi_axes)

    def value(self, x: Array) -> float:
        """Return phi at `x` (3,)."""
        return 0.5 * (float(self._curvatures @ (x * x)) - 1.0)

    def gradient(self, x: Array) -> Array:
        """Return the gradient (3,)."""
        return self._curvatures * x

    def hessian(self, x: Array) -> Array:
        """Return the Hessian (3, 3), which is constant."""
        return np.diag(self._curvatures)
