"""Surfaces as kernels evaluate them: value, gradient and Hessian at a point, in one go."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import ClassVar

import numpy as np

from equipoise.compiled import compiled, entrance, specialised
from equipoise.contacts.surfaces.base import Surface, VanishingGradientError
from equipoise.spatial import Array

# kinds of surfaces as kernels know them; a surface of one's own is asked from Python
OWN, PLANE, SPHERE, CYLINDER, ELLIPSOID, TORUS = range(6)
VALUE, GRADIENT, HESSIAN = 0, 1, 4  # where they begin in a sample
SAMPLE = 13  # numbers of a sample


class KernelSurface(Surface):
    """A surface that a kernel evaluates from `numbers`, at most three; `kind` tells which.

    `alone` calls its kernel from Python, made by `sampled_by`.
    """

    kind: ClassVar[int]
    alone: ClassVar[Callable[[Array, Array, Array], None]]

    @property
    @abstractmethod
    def numbers(self) -> Array:
        """Its lengths [m] (3,)."""

    def sample(self, x: Array) -> Array:
        """Return value, gradient and Hessian by rows (13,) at `x` (3,).

        Raises: `VanishingGradientError` where there is no normal.
        """
        out = np.empty(SAMPLE)
        type(self).alone(self.numbers, np.array(x, dtype=float), out)
        if not np.isfinite(out[GRADIENT:]).all():
            raise VanishingGradientError(self.name, x)
        return out

    def value(self, x: Array) -> float:
        """Return phi at `x` (3,)."""
        out = np.empty(SAMPLE)
        type(self).alone(self.numbers, np.array(x, dtype=float), out)
        return float(out[VALUE])

    def gradient(self, x: Array) -> Array:
        """Return the gradient (3,)."""
        return self.sample(x)[GRADIENT:HESSIAN]

    def hessian(self, x: Array) -> Array:
        """Return the Hessian (3, 3)."""
        return self.sample(x)[HESSIAN:].reshape(3, 3)


def sampled_by(name: str, kernel: Callable[..., None]) -> Callable[..., None]:
    """Return an entrance that samples one surface: numbers [3], point [3], out [13]."""
    return entrance(specialised(_alone, f"{name}_alone", sample_of=kernel))


def sample_of(numbers: Array, x: float, y: float, z: float, out: Array) -> None:
    """Stand for the kernel of a surface in `_alone`."""
    raise NotImplementedError


def _alone(numbers: np.ndarray, x: np.ndarray, out: np.ndarray) -> None:
    sample_of(numbers, x[0], x[1], x[2], out)


@compiled
def no_normal(out: np.ndarray) -> None:
    """Say that there is no normal here."""
    for i in range(1, 13):
        out[i] = np.nan
