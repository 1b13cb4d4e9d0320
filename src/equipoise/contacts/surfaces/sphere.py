"""A sphere about the origin of its own coordinates."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from equipoise.compiled import compiled
from equipoise.contacts.surfaces.base import require_length
from equipoise.contacts.surfaces.sample import SPHERE, KernelSurface, no_normal, sampled_by
from equipoise.spatial import Array


@compiled
def sphere_sample(numbers: np.ndarray, x: float, y: float, z: float, out: np.ndarray) -> None:
    """Write `phi = |x| - radius` with gradient n and Hessian `(I - n n^T) / |x|`."""
    length = math.sqrt(x * x + y * y + z * z)
    out[0] = length - numbers[0]
    if length < 1e-9 * numbers[0]:
        no_normal(out)
        return
    out[1], out[2], out[3] = x / length, y / length, z / length
    for i in range(3):
        for k in range(3):
            out[4 + 3 * i + k] = ((1.0 if i == k else 0.0) - out[1 + i] * out[1 + k]) / length


@dataclass(frozen=True)
class Sphere(KernelSurface):
    """`phi = |x| - radius`, the distance; it has no normal at the centre."""

    radius: float
    kind = SPHERE
    alone = staticmethod(sampled_by("sphere", sphere_sample))

    def __post_init__(self) -> None:
        require_length("sphere", "radius", self.radius)

    @property
    def numbers(self) -> Array:
        """The radius [m]."""
        return np.array([self.radius, 0.0, 0.0])
