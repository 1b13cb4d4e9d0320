"""A surface of the user's own: phi with gradient and Hessian, checked when it is given."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from equipoise.contacts.surfaces.base import Surface, VanishingGradientError
from equipoise.errors import InputError, NonFiniteError, ShapeError
from equipoise.spatial import Array

_SAMPLES = 12
_STEP = 1e-5  # of the radius: balances rounding and truncation of a central difference
_AGREEMENT = 1e-5  # of the largest entry: central differences are good to some 1e-9


class WrongDerivativeError(InputError):
    """A gradient or Hessian that is not the derivative of the phi it came with."""


@dataclass(frozen=True)
class ImplicitSurface(Surface):
    """`phi(x) = 0` for functions of x (3,) [m] that return phi, gradient (3,), Hessian (3, 3).

    `near` (3,) is a point near the part of the surface that will be touched; the derivatives are
    compared with finite differences there and at random points within `radius` [m] of it.
    Raises: `WrongDerivativeError`, `VanishingGradientError`, `ShapeError`, `NonFiniteError`.
    """

    label: str
    phi: Callable[[Array], float]
    phi_gradient: Callable[[Array], Array]
    phi_hessian: Callable[[Array], Array]
    near: tuple[float, float, float]
    radius: float = 0.05

    def __post_init__(self) -> None:
        if len(self.near) != 3:
            raise ShapeError(f"near of surface {self.label!r}", (len(self.near),), (3,))
        if not (np.isfinite(self.radius) and self.radius > 0.0):
            raise InputError("the radius must be finite and positive [m]", given=self.radius)
        generator = np.random.default_rng(0)
        start = np.array(self.near, dtype=float)
        self._check_at(start)
        foot = self._point_on_the_surface(start)
        for offset in generator.uniform(-1.0, 1.0, (_SAMPLES, 3)):
            self._check_at(foot + self.radius * offset / np.sqrt(3.0))

    @property
    def name(self) -> str:
        """What errors call it."""
        return self.label

    def value(self, x: Array) -> float:
        """Return phi at `x` (3,)."""
        return float(self.phi(x))

    def gradient(self, x: Array) -> Array:
        """Return the gradient (3,) that was given."""
        return np.asarray(self.phi_gradient(x), dtype=float)

    def hessian(self, x: Array) -> Array:
        """Return the Hessian (3, 3) that was given."""
        return np.asarray(self.phi_hessian(x), dtype=float)

    def _point_on_the_surface(self, start: Array) -> Array:
        """Return the projection of `start`, whose gradient must still be there on the surface.

        On a double zero (phi^2) the gradient dies with phi: the projection then creeps, and its
        gradient ends far below what it was at the start.
        """
        foot = self.project(start)
        scale = max(self.steepness(start + offset) for offset in self.radius * np.eye(3))
        if self.steepness(foot) < 1e-6 * scale:
            raise VanishingGradientError(self.name, foot)
        return foot

    def _check_at(self, x: Array) -> None:
        gradient, hessian = self.gradient(x), self.hessian(x)
        for what, given, shape in (("gradient", gradient, (3,)), ("Hessian", hessian, (3, 3))):
            if given.shape != shape:
                raise ShapeError(f"{what} of surface {self.name!r}", given.shape, shape)
        self._require_finite(x, gradient, hessian)
        step = _STEP * self.radius
        ahead = [x + step * axis for axis in np.eye(3)]
        behind = [x - step * axis for axis in np.eye(3)]
        pairs = list(zip(ahead, behind, strict=True))
        slopes = np.array([self.value(a) - self.value(b) for a, b in pairs]) / (2.0 * step)
        bends = np.array([self.gradient(a) - self.gradient(b) for a, b in pairs]) / (2.0 * step)
        noise = 1e-14 * max(abs(self.value(a)) for a in ahead) / step
        self._compare("gradient", x, gradient, slopes, noise)
        noise = 1e-14 * float(np.abs(gradient).max()) / step
        self._compare("Hessian", x, hessian, bends, noise)

    def _require_finite(self, x: Array, gradient: Array, hessian: Array) -> None:
        numbers = np.concatenate(([self.value(x)], gradient, hessian.ravel()))
        if not np.isfinite(numbers).all():
            raise NonFiniteError(
                f"surface {self.name!r} gives a NaN or an infinity", given=[float(v) for v in x]
            )

    def _compare(self, what: str, x: Array, given: Array, differences: Array, noise: float) -> None:
        scale = max(float(np.abs(differences).max()), float(np.abs(given).max()))
        if np.abs(given - differences).max() <= _AGREEMENT * scale + noise:
            return
        place = ", ".join(f"{value:.6g}" for value in x)
        raise WrongDerivativeError(
            f"the {what} of surface {self.name!r} is not the derivative of what it came with: "
            f"at ({place}) finite differences give {differences.round(6).tolist()}",
            given=given.round(6).tolist(),
            remedy=f"Correct the {what} function, or `near` if phi is not smooth there",
        )
