"""A torus about the z axis of its own coordinates."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from equipoise.compiled import compiled, scratch
from equipoise.contacts.surfaces.base import require_length
from equipoise.contacts.surfaces.sample import TORUS, KernelSurface, no_normal, sampled_by
from equipoise.errors import InputError
from equipoise.spatial import Array


@compiled
def torus_sample(numbers: np.ndarray, x: float, y: float, z: float, out: np.ndarray) -> None:
    """Write the distance to the tube with gradient n and Hessian.

    Its curvature is `across / (rho length)` along the ring and `1 / length` round the tube.
    """
    ring, tube = numbers[0], numbers[1]
    rho = math.sqrt(x * x + y * y)
    across = rho - ring
    length = math.sqrt(across * across + z * z)
    out[0] = length - tube
    if min(rho, length) < 1e-9 * tube:
        no_normal(out)
        return
    rx, ry = x / rho, y / rho
    nx, ny, nz = across * rx / length, across * ry / length, z / length
    out[1], out[2], out[3] = nx, ny, nz
    along, around = scratch(3), scratch(3)  # unit vectors along the ring and round the tube
    along[0], along[1], along[2] = -ry, rx, 0.0
    around[0], around[1], around[2] = rx * nz, ry * nz, -(ry * ny + rx * nx)
    bend = across / (rho * length)
    for i in range(3):
        for k in range(3):
            out[4 + 3 * i + k] = bend * along[i] * along[k] + around[i] * around[k] / length


@dataclass(frozen=True)
class Torus(KernelSurface):
    """`phi = sqrt((sqrt(x^2 + y^2) - ring)^2 + z^2) - tube`, the distance.

    `ring` [m] is the radius of the circle in the plane z = 0 that the tube of radius `tube` [m]
    follows. It has no normal on that circle nor on the axis.
    """

    ring: float
    tube: float
    kind = TORUS
    alone = staticmethod(sampled_by("torus", torus_sample))

    def __post_init__(self) -> None:
        require_length("torus", "ring", self.ring)
        require_length("torus", "tube", self.tube)
        if self.tube >= self.ring:
            raise InputError(
                "the tube of a torus must be thinner than its ring, else it cuts itself",
                given={"ring": self.ring, "tube": self.tube},
            )

    @property
    def numbers(self) -> Array:
        """Ring and tube [m]."""
        return np.array([self.ring, self.tube, 0.0])
