"""A scalar wanted over time, what every kind offers."""

from __future__ import annotations

from abc import ABC, abstractmethod

from equipoise.spatial import Array

# kinds of scalars as kernels know them; a GIVEN one is written from Python
GIVEN, PROFILE, PUSHING, LIVE = range(4)


class ScalarTrajectory(ABC):
    """A number as a function of time. One of your own gives `at`; the tick then asks it."""

    kind = GIVEN

    @abstractmethod
    def at(self, t: float) -> float:
        """Return the wanted value at time `t` [s]."""

    @property
    def least(self) -> float | None:
        """The least value it ever has, None if it does not know."""
        return None


class CompiledScalar(ScalarTrajectory):
    """A scalar that a kernel evaluates from `numbers`; `kind` is its number in `scalars`."""

    @property
    @abstractmethod
    def numbers(self) -> Array:
        """What the kernel needs (k,)."""
