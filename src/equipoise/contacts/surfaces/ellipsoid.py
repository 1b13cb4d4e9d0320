"""An ellipsoid about the origin, its axes along those of its own coordinates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from equipoise.compiled import compiled
from equipoise.contacts.surfaces.base import require_length
from equipoise.contacts.surfaces.sample import ELLIPSOID, KernelSurface, sampled_by
from equipoise.errors import ShapeError
from equipoise.spatial import Array


@compiled
def ellipsoid_sample(numbers: np.ndarray, x: float, y: float, z: float, out: np.ndarray) -> None:
    """Write `phi = (sum (x_i / a_i)^2 - 1) / 2` with gradient and Hessian, which is constant."""
    for i in range(4, 13):
        out[i] = 0.0
    total = -1.0
    for i in range(3):
        along = x if i == 0 else (y if i == 1 else z)
        curvature = 1.0 / (numbers[i] * numbers[i])
        total += curvature * along * along
        out[1 + i], out[4 + 4 * i] = curvature * along, curvature
    out[0] = 0.5 * total


@dataclass(frozen=True)
class Ellipsoid(KernelSurface):
    """`phi = (sum (x_i / a_i)^2 - 1) / 2` with semi-axes `a` (3,) [m]; not a distance."""

    semi_axes: tuple[float, float, float]
    kind = ELLIPSOID
    alone = staticmethod(sampled_by("ellipsoid", ellipsoid_sample))

    def __post_init__(self) -> None:
        if len(self.semi_axes) != 3:
            raise ShapeError("semi_axes of an ellipsoid", (len(self.semi_axes),), (3,))
        for length in self.semi_axes:
            require_length("ellipsoid", "semi-axis", length)

    @property
    def numbers(self) -> Array:
        """The semi-axes [m]."""
        return np.array(self.semi_axes, dtype=float)
