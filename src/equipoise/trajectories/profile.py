"""A scalar wanted over time: values at times, joined by minimum-jerk steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from equipoise.errors import InputError


@dataclass(frozen=True)
class Profile:
    """Holds `values` before the first and after the last of `times` [s]; smooth in between."""

    times: tuple[float, ...]
    values: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.times) != len(self.values) or not self.times:
            raise InputError("a profile needs as many values as times, at least one of each")
        if any(np.diff(self.times) <= 0.0):
            raise InputError("the times of a profile must increase", given=self.times)

    @classmethod
    def of(cls, times: Sequence[float], values: Sequence[float]) -> Profile:
        """Return the profile through `values` at `times` [s]."""
        return cls(tuple(times), tuple(values))

    def at(self, t: float) -> float:
        """Return the wanted value at time `t` [s]."""
        k = int(np.searchsorted(self.times, t, side="right"))
        if k == 0:
            return self.values[0]
        if k == len(self.times):
            return self.values[-1]
        x = (t - self.times[k - 1]) / (self.times[k] - self.times[k - 1])
        share = x**3 * (10.0 - 15.0 * x + 6.0 * x * x)
        return self.values[k - 1] + share * (self.values[k] - self.values[k - 1])
