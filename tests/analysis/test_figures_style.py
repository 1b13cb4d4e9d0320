"""Thinning of curves keeps what an eye would miss."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from equipoise.analysis.figures.style import decimate, number


@settings(max_examples=60, deadline=None)
@given(st.integers(1, 9000), st.integers(20, 2000), st.integers(0, 2**32 - 1))
def test_decimation_keeps_ends_extremes_and_order(count, points, seed):
    rng = np.random.default_rng(seed)
    t, y = np.arange(count) * 1e-3, rng.normal(size=count)
    x, values = decimate(t, y, points)
    assert len(x) <= max(points, 1)
    assert (np.diff(x) > 0.0).all()
    assert (x[0], x[-1]) == (t[0], t[-1])
    assert (values.min(), values.max()) == (y.min(), y.max())
    np.testing.assert_array_equal(values, y[np.searchsorted(t, x)])  # samples, nothing made up


@pytest.mark.parametrize("place", [0, 1, 4321, 8998, 8999])
def test_a_single_spike_survives(place):
    y = np.zeros(9000)
    y[place] = 7.0
    assert decimate(np.arange(9000.0), y)[1].max() == 7.0


def test_short_curves_are_left_alone():
    t, y = np.arange(30.0), np.arange(30.0) ** 2
    x, values = decimate(t, y)
    np.testing.assert_array_equal(x, t)
    np.testing.assert_array_equal(values, y)


def test_gaps_stay_gaps():
    t, y = np.arange(9000.0), np.ones(9000)
    y[3000:3010], y[5000] = np.nan, -np.inf
    x, values = decimate(t, y)
    missing = x[np.isnan(values)]
    assert ((missing >= 3000) & (missing < 3010)).any()
    assert 5000.0 in missing
    assert len(missing) <= 4  # the tail of the last stretch is no gap
    assert np.isfinite(values[-1])
    assert np.isnan(decimate(t, np.full(9000, np.nan))[1]).all()


def test_minus_is_a_minus():
    assert number(-1.25, ".1f") == "\N{MINUS SIGN}1.2"
