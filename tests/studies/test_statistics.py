"""Statistics against independent formulas."""

from __future__ import annotations

from itertools import product
from math import comb, sqrt

import numpy as np
import pytest

from equipoise.studies.compare.statistics import mcnemar, paired_difference, share


def wilson(k: int, n: int, z: float) -> tuple[float, float]:
    """Solve |p - k/n| = z sqrt(p (1 - p) / n) for p, a quadratic equation."""
    a, b, c = 1.0 + z * z / n, -(2.0 * k / n + z * z / n), (k / n) ** 2
    root = sqrt(max(b * b - 4.0 * a * c, 0.0))
    return (-b - root) / (2.0 * a), (-b + root) / (2.0 * a)


@pytest.mark.parametrize(("k", "n"), [(0, 10), (45, 50), (10, 10), (7, 200), (1, 1)])
def test_the_interval_solves_its_equation(k: int, n: int) -> None:
    found = share(np.arange(n) < k)
    low, high = wilson(k, n, 1.959963984540054)
    assert (found.count, found.of) == (k, n)
    assert found.low == pytest.approx(low, abs=1e-12)
    assert found.high == pytest.approx(high, abs=1e-12)


def test_the_interval_holds_the_true_share_about_as_often_as_it_says() -> None:
    """Exactly, by summing the binomial distribution: between 93 and 97 % on average over shares."""
    n, held = 40, []
    intervals = [share(np.arange(n) < k) for k in range(n + 1)]
    for p in np.linspace(0.05, 0.95, 91):
        within = [k for k, one in enumerate(intervals) if one.low <= p <= one.high]
        held.append(sum(comb(n, k) * p**k * (1.0 - p) ** (n - k) for k in within))
    assert 0.93 < np.mean(held) < 0.97


def test_nothing_has_no_share() -> None:
    assert np.isnan(share(np.zeros(0, dtype=bool)).value)


def test_mcnemar_counts_all_ways_in_which_pairs_can_differ() -> None:
    """Against every one of the 2^7 equally likely outcomes of the pairs that differ."""
    first = np.array([1, 1, 1, 1, 1, 1, 0, 1, 0, 0], dtype=bool)
    second = np.array([0, 0, 0, 0, 0, 0, 1, 1, 0, 0], dtype=bool)
    found = mcnemar(first, second)
    assert (found.both, found.only_first, found.only_second, found.neither) == (1, 6, 1, 2)
    ways = [sum(way) for way in product((0, 1), repeat=7)]
    as_uneven = sum(abs(way - 3.5) >= 2.5 for way in ways)
    assert found.p == pytest.approx(as_uneven / 2**7)
    assert mcnemar(first, first).p == 1.0


def test_signed_ranks_count_all_signs() -> None:
    """Against every one of the 2^6 equally likely signs of six differences."""
    first = np.zeros(6)
    second = np.array([1.0, 2.0, 3.0, 4.0, -5.0, 6.0])
    found = paired_difference(first, second)
    ranks = np.arange(1, 7)
    observed = abs(2 * sum(r for r, x in zip(ranks, second, strict=True) if x > 0) - ranks.sum())
    sums = [abs(2 * ranks[np.array(signs, bool)].sum() - ranks.sum())
            for signs in product((0, 1), repeat=6)]  # fmt: skip
    assert found.p == pytest.approx(np.mean([s >= observed for s in sums]))
    assert found.quartiles[1] == 2.5
    assert paired_difference(first, first).p == 1.0
