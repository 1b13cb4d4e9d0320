"""Least and largest value of many curves in stretches of time, gathered piece by piece."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from equipoise.spatial import Array
from equipoise.viewer.curves import Curve

STRETCHES = 400


class Envelope:
    """Gathers `curves` over [`start`, `stop`] [s]; pieces may come in any order."""

    def __init__(
        self, curves: Sequence[Curve], start: float, stop: float, stretches: int = STRETCHES
    ) -> None:
        self.curves = tuple(curves)
        self.start, self.stop = start, stop
        self.stretches = stretches
        shape = (stretches, len(self.curves))
        self._least = np.full(shape, np.inf)
        self._largest = np.full(shape, -np.inf)
        self._t_least = np.zeros(shape)
        self._t_largest = np.zeros(shape)

    def add(self, arrays: Mapping[str, Array]) -> None:
        """Take a piece: arrays (n, k) by channel and "t" (n,)."""
        t = arrays["t"]
        with np.errstate(over="ignore", invalid="ignore"):
            values = np.column_stack([curve.compute(arrays) for curve in self.curves])
        span = max(self.stop - self.start, 1e-12)
        stretch = ((t - self.start) / span * self.stretches).astype(int)
        stretch = np.clip(stretch, 0, self.stretches - 1)
        bounds = np.flatnonzero(np.diff(stretch)) + 1
        for part in np.split(np.arange(len(t)), bounds):
            self._merge(int(stretch[part[0]]), t[part], values[part])

    def of(self, indices: Sequence[int]) -> tuple[Array, Array]:
        """Return times (n,) and values (n, len(indices)) of chosen curves, NaN where unknown.

        Every stretch gives two moments, and each curve its two extremes in their true order.
        """
        indices = list(indices)
        least, largest = self._least[:, indices], self._largest[:, indices]
        rising = self._t_least[:, indices] <= self._t_largest[:, indices]
        values = np.empty((2 * self.stretches, len(indices)))
        values[0::2] = np.where(rising, least, largest)
        values[1::2] = np.where(rising, largest, least)
        values[~np.isfinite(values)] = np.nan
        moments = (np.arange(2 * self.stretches) + 0.5) / (2 * self.stretches)
        t = self.start + (self.stop - self.start) * moments
        seen = np.isfinite(self._least).any(axis=1).repeat(2)
        return t[seen], values[seen]

    def lowest(self, indices: Sequence[int], count: int) -> list[int]:
        """Return those `count` of the curves that come lowest anywhere."""
        least = self._least[:, list(indices)].min(axis=0)
        return sorted(indices[i] for i in np.argsort(least, kind="stable")[:count])

    def _merge(self, stretch: int, t: Array, values: Array) -> None:
        known = np.isfinite(values)
        low = np.where(known, values, np.inf)
        high = np.where(known, values, -np.inf)
        at_low, at_high = low.argmin(axis=0), high.argmax(axis=0)
        columns = np.arange(values.shape[1])
        low, high = low[at_low, columns], high[at_high, columns]
        lower, higher = low < self._least[stretch], high > self._largest[stretch]
        self._least[stretch, lower] = low[lower]
        self._t_least[stretch, lower] = t[at_low[lower]]
        self._largest[stretch, higher] = high[higher]
        self._t_largest[stretch, higher] = t[at_high[higher]]
