"""A torus about the z axis of its own coordinates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from equipoise.contacts.surfaces.base import Surface, VanishingGradientError, require_length
from equipoise.errors import InputError
from equipoise.spatial import Array


@dataclass(frozen=True)
class Torus(Surface):
    """`phi = sqrt((sqrt(x^2 + y^2) - ring)^2 + z^2) - tube`, the distance.

    `ring` [m] is the radius of the circle in the plane z = 0 that the tube of radius `tube` [m]
    follows. It has no normal on that circle nor on the axis.
    """

    ring: float
    tube: float

    def __post_init__(self) -> None:
        require_length("torus", "ring", self.ring)
        require_length("torus", "tube", self.tube)
        if self.tube >= self.ring:
            raise InputError(
                "the tube of a torus must be thinner than its ring, else it cuts itself",
                given={"ring": self.ring, "tube": self.tube},
            )

    def value(self, x: Array) -> float:
        """Return phi at `x` (3,)."""
        return float(np.hypot(np.hypot(x[0], x[1]) - self.ring, x[2])) - self.tube

    def gradient(self, x: Array) -> Array:
        """Return the gradient (3,)."""
        radial, _, across, length = self._section(x)
        return (across * radial + np.array([0.0, 0.0, x[2]])) / length

    def hessian(self, x: Array) -> Array:
        """Return the Hessian (3, 3): curvature along the ring and across it."""
        radial, rho, across, length = self._section(x)
        along = np.array([-radial[1], radial[0], 0.0])
        normal = self.gradient(x)
        round_tube = np.cross(along, normal)
        along_ring = across / (rho * length) * np.outer(along, along)
        return along_ring + np.outer(round_tube, round_tube) / length

    def _section(self, x: Array) -> tuple[Array, float, float, float]:
        """Return the radial direction, radius, its excess over the ring, distance to the ring."""
        rho = float(np.hypot(x[0], x[1]))
        across = rho - self.ring
        length = float(np.hypot(across, x[2]))
        if min(rho, length) < 1e-9 * self.tube:
            raise VanishingGradientError(self.name, x)
        return np.array([x[0] / rho, x[1] / rho, 0.0]), rho, across, length
