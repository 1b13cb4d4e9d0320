"""What every surface provides: phi with gradient and Hessian, in coordinates of its own."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from equipoise.errors import InputError
from equipoise.spatial import Array

_LEAST_GRADIENT = 1e-9
_NEWTON_STEPS = 50


class VanishingGradientError(InputError):
    """A place where a surface has no normal, because the gradient of its phi vanishes."""

    def __init__(self, surface: str, x: Array) -> None:
        place = ", ".join(f"{value:.6g}" for value in x)
        super().__init__(
            f"the gradient of surface {surface!r} vanishes at ({place}) in its own coordinates",
            remedy="Use a phi with a nonzero gradient on the surface (phi^2 has none), and keep "
            "the contact point near the surface, away from centres and axes",
        )
        self.surface = surface


@dataclass(frozen=True)
class Surface(ABC):
    """A smooth surface `phi(x) = 0`; phi > 0 is the side on which the robot is.

    Coordinates `x` (3,) [m] are the surface's own; a contact places it in the world.
    Source: eq. (13). Differs from the print: none.
    """

    @property
    def name(self) -> str:
        """What errors call it."""
        return type(self).__name__.lower()

    @abstractmethod
    def value(self, x: Array) -> float:
        """Return phi at `x` (3,)."""

    @abstractmethod
    def gradient(self, x: Array) -> Array:
        """Return the gradient (3,) of phi at `x` (3,)."""

    @abstractmethod
    def hessian(self, x: Array) -> Array:
        """Return the Hessian (3, 3) of phi at `x` (3,)."""

    def steepness(self, x: Array) -> float:
        """Return `|gradient|` at `x` (3,).

        Raises: `VanishingGradientError` where there is no normal.
        """
        gradient = self.gradient(x)
        steepness = float(np.sqrt(gradient @ gradient))
        if not steepness > _LEAST_GRADIENT:
            raise VanishingGradientError(self.name, x)
        return steepness

    def normal(self, x: Array) -> Array:
        """Return the unit normal (3,) at `x` (3,), out of the object, toward the robot.

        Raises: `VanishingGradientError`.
        """
        return self.gradient(x) / self.steepness(x)

    def distance(self, x: Array) -> float:
        """Return the signed distance [m] of `x` (3,) to first order, positive outside.

        Raises: `VanishingGradientError`.
        """
        return self.value(x) / self.steepness(x)

    def project(self, x: Array) -> Array:
        """Return the point (3,) of the surface that is reached from `x` (3,) along the gradient.

        For plane, sphere, cylinder and torus it is the nearest one.
        Raises: `VanishingGradientError`; `InputError` if no point of the surface is reached.
        """
        point = np.array(x, dtype=float)
        for _ in range(_NEWTON_STEPS):
            distance = self.distance(point)
            point = point - distance * self.normal(point)
            if abs(distance) < 1e-14:
                return point
        if abs(self.distance(point)) < 1e-9:
            return point
        raise InputError(
            f"from this point no point of surface {self.name!r} is reached",
            given=[float(value) for value in x],
            remedy="Start nearer to the surface, and check that phi has a zero there",
        )


def require_length(surface: str, what: str, value: float) -> None:
    """Refuse a length [m] that is not finite and positive.

    Raises: `InputError`.
    """
    if not (np.isfinite(value) and value > 0.0):
        raise InputError(f"the {what} of a {surface} must be finite and positive [m]", given=value)
