"""Leaning into a push: the pendulum's own equation, and what it answers to forces that last."""

from __future__ import annotations

import numpy as np
import pytest

from equipoise.errors import InputError
from equipoise.walking import Leaning

OMEGA = 3.6


def pushed(dt: float, *, end: float = 6.0, start: float = 2.0) -> np.ndarray:
    """Return a point that goes 5 cm ahead within a second."""
    t = np.arange(round(end / dt)) * dt
    x = np.clip(t - start, 0.0, 1.0)
    return np.column_stack((0.05 * x**3 * (10.0 - 15.0 * x + 6.0 * x**2), np.zeros_like(t)))


@pytest.mark.parametrize(("dt", "most"), [(1e-3, 1e-5), (4e-3, 1e-4)])
def test_it_is_a_pendulum_over_the_point(dt, most):
    """`p - p''/omega^2 = d`: what the soles feel is what was planned."""
    d = pushed(dt)
    leaning = Leaning(OMEGA, dt, d)
    bend = (leaning.v[2:-1] - leaning.v[:-3]) / (2.0 * dt)  # the last sample comes to rest
    assert np.abs(leaning.p[1:-2] - bend / OMEGA**2 - d[1:-2]).max() < most
    mean = 0.5 * (leaning.v[1:-1] + leaning.v[:-2])
    assert np.abs(np.diff(leaning.p[:-1], axis=0) / dt - mean).max() < most


def test_it_leads_and_ends_over_the_point():
    leaning = Leaning(OMEGA, 1e-3, pushed(1e-3))
    assert 1e-4 < leaning.at(1.9)[0][0] < 5e-3  # before there is a force
    assert leaning.at(0.0)[0] == pytest.approx([0.0, 0.0], abs=1e-5)
    assert leaning.at(99.0)[0] == pytest.approx([0.05, 0.0], abs=1e-5)
    assert leaning.at(99.0)[1] == pytest.approx([0.0, 0.0])


def test_a_force_that_lasts_from_the_start_is_leant_into_from_the_start():
    p, v = Leaning(OMEGA, 1e-3, np.full((500, 2), 0.03)).at(0.1)
    assert p == pytest.approx([0.03, 0.03], abs=1e-9)
    assert np.abs(v).max() < 1e-9


@pytest.mark.parametrize("d", [np.zeros((1, 2)), np.zeros((5, 3)), np.full((5, 2), np.nan)])
def test_what_is_no_way_is_refused(d):
    with pytest.raises(InputError, match="two finite points"):
        Leaning(OMEGA, 1e-3, d)
