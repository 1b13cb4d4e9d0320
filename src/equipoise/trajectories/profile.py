"""A scalar through values at times, joined by minimum-jerk steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from equipoise.compiled import compiled, entrance
from equipoise.errors import InputError
from equipoise.spatial import Array
from equipoise.spatial.numbers import real_vector
from equipoise.trajectories.base import NEARLY, SHORTEST, instant
from equipoise.trajectories.minimum_jerk import step
from equipoise.trajectories.scalar import PROFILE, CompiledScalar


@dataclass(frozen=True)
class Profile(CompiledScalar):
    """Holds `values` before the first and after the last of `times` [s]; smooth in between."""

    times: tuple[float, ...]
    values: tuple[float, ...]
    kind = PROFILE

    def __post_init__(self) -> None:
        if len(self.times) != len(self.values) or not len(self.times):
            raise InputError(
                "a profile needs as many values as times, at least one of each",
                given=f"{len(self.times)} times, {len(self.values)} values",
            )
        times = real_vector("the times of a profile", self.times, len(self.times))
        real_vector("the values of a profile", self.values, len(self.values))
        if not (np.diff(times) >= NEARLY * SHORTEST).all():
            raise InputError(
                f"the times of a profile must increase, by {SHORTEST:g} s at least",
                given=times.tolist(),
            )

    @classmethod
    def of(cls, times: Sequence[float], values: Sequence[float]) -> Profile:
        """Return the profile through `values` at `times` [s]."""
        return cls(tuple(times), tuple(values))

    @cached_property
    def numbers(self) -> Array:
        """The times and then the values (2 k,)."""
        return np.array([*self.times, *self.values], dtype=float)

    @property
    def least(self) -> float:
        """The least of its values: between them it goes straight from one to the next."""
        return min(self.values)

    def at(self, t: float) -> float:
        """Return the wanted value at time `t` [s]."""
        return profile_alone(self.numbers, instant(t))


@compiled
def profile_at(numbers: np.ndarray, t: float) -> float:
    """Return the value of a profile at time t; its numbers are the times and then the values."""
    count = numbers.shape[0] // 2
    if t < numbers[0]:
        return numbers[count]
    k = 1
    while k < count and numbers[k] <= t:
        k += 1
    before = numbers[count + k - 1]
    if k == count:
        return before
    x = (t - numbers[k - 1]) / (numbers[k] - numbers[k - 1])
    return before + step(x) * (numbers[count + k] - before)


@entrance
def profile_alone(numbers: np.ndarray, t: float) -> float:
    """Return the value of one profile."""
    return profile_at(numbers, t)
