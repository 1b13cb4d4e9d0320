"""An infinite cylinder about the z axis of its own coordinates."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from equipoise.compiled import compiled
from equipoise.contacts.surfaces.base import require_length
from equipoise.contacts.surfaces.sample import CYLINDER, KernelSurface, no_normal, sampled_by
from equipoise.spatial import Array


@compiled
def cylinder_sample(numbers: np.ndarray, x: float, y: float, z: float, out: np.ndarray) -> None:
    """Write `phi = sqrt(x^2 + y^2) - radius` with gradient n and Hessian across the axis."""
    length = math.sqrt(x * x + y * y)
    out[0] = length - numbers[0]
    if length < 1e-9 * numbers[0]:
        no_normal(out)
        return
    for i in range(3, 13):
        out[i] = 0.0
    out[1], out[2] = x / length, y / length
    out[4], out[8] = (1.0 - out[1] * out[1]) / length, (1.0 - out[2] * out[2]) / length
    out[5] = out[7] = -out[1] * out[2] / length


@dataclass(frozen=True)
class Cylinder(KernelSurface):
    """`phi = sqrt(x^2 + y^2) - radius`, the distance; it has no normal on the axis."""

    radius: float
    kind = CYLINDER
    alone = staticmethod(sampled_by("cylinder", cylinder_sample))

    def __post_init__(self) -> None:
        require_length("cylinder", "radius", self.radius)

    @property
    def numbers(self) -> Array:
        """The radius [m]."""
        return np.array([self.radius, 0.0, 0.0])
