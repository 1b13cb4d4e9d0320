"""A fade is 0 outside its window, 1 inside, and smooth between."""

from __future__ import annotations

import math

import numpy as np
import pytest

from equipoise.errors import InputError
from equipoise.trajectories import Fade


def test_it_counts_inside_only_and_fully_between_the_ramps() -> None:
    fade = Fade(1.0, 3.0, 0.4)
    assert [fade.weight(t) for t in (0.0, 1.0, 1.4, 2.0, 3.0, 9.0)] == [
        0.0,
        0.0,
        1.0,
        1.0,
        0.0,
        0.0,
    ]
    assert fade.weight(1.2) == pytest.approx(0.5)
    assert fade.weight(2.8) == pytest.approx(0.5)


def test_its_slope_and_curvature_have_no_jump() -> None:
    fade = Fade(1.0, 3.0, 0.4)
    for h in (1e-2, 1e-3):
        w = np.array([fade.weight(t) for t in np.arange(0.9, 3.1, h)])
        assert np.abs(np.diff(w)).max() <= 1.875 / 0.4 * h * 1.001  # slope of a minimum-jerk step
        assert np.abs(np.diff(w, 3)).max() <= 60.0 / 0.4**3 * h**3 * 1.1


def test_without_a_ramp_it_is_a_switch_half_open_as_a_contact() -> None:
    fade = Fade(1.0, 3.0, 0.0)
    assert [fade.weight(t) for t in (0.999, 1.0, 2.999, 3.0)] == [0.0, 1.0, 1.0, 0.0]


def test_what_never_starts_or_ends_has_one_ramp() -> None:
    assert Fade().weight(-5.0) == 1.0
    assert Fade(end=2.0).weight(0.0) == 1.0
    assert Fade(start=1.0).weight(1e6) == 1.0


@pytest.mark.parametrize(
    "given",
    [(2.0, 1.0, 0.0), (0.0, 1.0, 0.6), (0.0, 1.0, -0.1), (0.0, 1.0, math.nan), (math.nan, 1, 0)],
)
def test_ramps_that_do_not_fit_are_refused(given) -> None:
    with pytest.raises(InputError, match="window"):
        Fade(*given)
