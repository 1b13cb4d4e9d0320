"""Shares with intervals, and tests on pairs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats

from equipoise.spatial import Array, Mask

LEVEL = 0.95


@dataclass(frozen=True)
class Share:
    """`count` of `of`, with the interval (Wilson) that holds the true share in 95 of 100 cases."""

    count: int
    of: int
    low: float
    high: float

    @property
    def value(self) -> float:
        """The share; NaN of nothing."""
        return self.count / self.of if self.of else float("nan")


def share(mask: Mask) -> Share:
    """Return which share of (n,) truth values is true.

    Source: Wilson (1927), by scipy.stats.binomtest.
    """
    count, of = int(np.sum(mask)), len(mask)
    if not of:
        return Share(0, 0, 0.0, 1.0)
    interval = stats.binomtest(count, of).proportion_ci(LEVEL, method="wilson")
    return Share(count, of, float(interval.low), float(interval.high))


@dataclass(frozen=True)
class PairedTest:
    """Of pairs: both true, only the first, only the second, neither; `p` that it is chance."""

    both: int
    only_first: int
    only_second: int
    neither: int
    p: float


def mcnemar(first: Mask, second: Mask) -> PairedTest:
    """Compare two series (n,) of truth values on the same points, exactly.

    Under the null hypothesis a pair that differs is as likely to favour either side.
    Source: McNemar (1947), the exact form: scipy.stats.binomtest, two-sided.
    """
    first, second = first.astype(bool), second.astype(bool)
    a, b = int((first & ~second).sum()), int((~first & second).sum())
    p = float(stats.binomtest(a, a + b, 0.5).pvalue) if a + b else 1.0
    return PairedTest(int((first & second).sum()), a, b, int((~first & ~second).sum()), p)


@dataclass(frozen=True)
class Difference:
    """Paired differences: how many, quartiles, and `p` that they are symmetric about zero."""

    count: int
    quartiles: tuple[float, float, float]
    p: float


def paired_difference(first: Array, second: Array) -> Difference:
    """Return how `second` (n,) differs from `first` (n,), pair by pair.

    Source: Wilcoxon (1945), signed ranks, two-sided: scipy.stats.wilcoxon.
    """
    change = np.asarray(second, float) - np.asarray(first, float)
    change = change[np.isfinite(change)]
    if not len(change):
        return Difference(0, (np.nan, np.nan, np.nan), np.nan)
    low, middle, high = (float(x) for x in np.percentile(change, (25, 50, 75)))
    p = float(stats.wilcoxon(change).pvalue) if np.any(change) else 1.0
    return Difference(len(change), (low, middle, high), p)
