"""The plane z = 0 of its own coordinates, the robot on the side of positive z."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from equipoise.compiled import compiled
from equipoise.contacts.surfaces.sample import PLANE, KernelSurface, sampled_by
from equipoise.spatial import Array


@compiled
def plane_sample(numbers: np.ndarray, x: float, y: float, z: float, out: np.ndarray) -> None:
    """Write `phi = z` with gradient and Hessian."""
    for i in range(1, 13):
        out[i] = 0.0
    out[0], out[3] = z, 1.0


@dataclass(frozen=True)
class Plane(KernelSurface):
    """`phi = z`, the distance."""

    kind = PLANE
    alone = staticmethod(sampled_by("plane", plane_sample))

    @property
    def numbers(self) -> Array:
        """None."""
        return np.zeros(3)
