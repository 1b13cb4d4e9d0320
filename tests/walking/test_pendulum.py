"""The pendulum in closed form against its differential equation and its integral."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from walks import FEET, PLANNER, STANCE

from equipoise.walking import Stride, steps_along
from equipoise.walking.centre import CentreState
from equipoise.walking.pendulum import PendulumPath, ZmpMove
from equipoise.walking.quasi_static import CentreMove, QuasiStaticPath

OMEGA = 3.5


def a_path(rng, start=0.7, count=7):
    goals = rng.normal(scale=0.1, size=(count, 2))
    times = rng.uniform(0.3, 1.0, size=count)
    moves = [ZmpMove(times[k], goals[k], k in (0, count - 2)) for k in range(count)]
    p, dcm, zmp = rng.normal(scale=0.01, size=(3, 2))
    nothing = np.zeros(2)
    return PendulumPath(OMEGA, start, CentreState(p, nothing, nothing, zmp, dcm), moves), (p, dcm)


def times_of(path, count=4001):
    return np.linspace(path.start, path.end, count)


def test_the_centre_obeys_the_equation_of_the_pendulum(rng):
    """c'' = omega^2 (c - zmp), the left side from differences of positions alone."""
    path, _ = a_path(rng)
    h = 3e-4
    for t in np.linspace(path.start + h, path.end - h, 500):
        low, here, high = (path.at(t + d) for d in (-h, 0.0, h))
        assert np.abs((high.p - 2.0 * here.p + low.p) / h**2 - here.a).max() < 2e-4
        assert np.abs((high.p - low.p) / (2.0 * h) - here.v).max() < 2e-5
        assert np.allclose(here.a, OMEGA**2 * (here.p - here.zmp), atol=1e-12)
        assert np.allclose(here.dcm, here.p + here.v / OMEGA, atol=1e-12)


def test_the_divergent_component_is_the_bounded_one(rng):
    """xi(t) = omega int_t^inf exp(-omega (s - t)) zmp(s) ds, by quadrature over the future."""
    path, _ = a_path(rng)
    x, w = np.polynomial.legendre.leggauss(20)
    for t in np.linspace(path.start, path.end, 40):
        total = path.at(path.end).zmp * np.exp(-OMEGA * (path.end - t))
        for a, b in pairwise([t, *(s for s in path._starts if s > t), path.end]):
            s = 0.5 * (b - a) * (x + 1.0) + a
            zmp = np.array([path.at(one).zmp for one in s])
            total = total + 0.5 * (b - a) * w * OMEGA * np.exp(-OMEGA * (s - t)) @ zmp
        assert np.allclose(path.at(t).dcm, total, atol=1e-10)


def test_it_stays_within_what_the_zero_moment_points_span(rng):
    """A mean of zero-moment points with positive weights lies in the box around them."""
    path, _ = a_path(rng)
    states = [path.at(t) for t in times_of(path)]
    zmp, dcm = (np.array([getattr(s, name) for s in states]) for name in ("zmp", "dcm"))
    assert (dcm <= zmp.max(axis=0) + 1e-9).all()
    assert (dcm >= zmp.min(axis=0) - 1e-9).all()


def test_it_begins_as_is_wanted_and_ends_at_rest(rng):
    path, (p, dcm) = a_path(rng)
    first, last = path.at(path.start), path.at(path.end - 1e-12)
    assert np.allclose(first.p, p, atol=1e-12)
    assert np.allclose(first.dcm, dcm, atol=1e-10)
    assert np.allclose(last.p, path.at(path.end).p, atol=1e-9)
    assert np.abs(last.v).max() < 1e-9
    assert np.abs(last.a).max() < 1e-8


@pytest.mark.parametrize("kind", ["pendulum", "slow"])
def test_it_is_continuous_to_the_second_derivative(rng, kind):
    """Across the ends of pieces position, velocity and acceleration change by what a step may."""
    if kind == "pendulum":
        path, _ = a_path(rng)
    else:
        goals = rng.normal(scale=0.1, size=(6, 2))
        path = QuasiStaticPath(OMEGA, 0.0, np.zeros(2), [CentreMove(0.6, g) for g in goals])
    h = 1e-6
    for t in path._starts[1:]:
        before, behind = path.at(t - h), path.at(t + h)
        assert np.abs(behind.p - before.p).max() < 5e-6
        assert np.abs(behind.v - before.v).max() < 5e-5
        assert np.abs(behind.a - before.a).max() < 5e-4


def test_slow_moves_take_the_zmp_beyond_their_ends_by_the_formula():
    """5.77 D / (omega T)^2 behind a minimum-jerk move over D in T."""
    D, T = 0.1, 1.3
    path = QuasiStaticPath(OMEGA, 0.0, np.zeros(2), [CentreMove(T, np.array([D, 0.0]))])
    zmp = np.array([path.at(t).zmp[0] - path.at(t).p[0] for t in times_of(path)])
    assert np.abs(zmp).max() == pytest.approx(10.0 / np.sqrt(3.0) * D / (OMEGA * T) ** 2, rel=1e-5)


def test_plain_numbers_are_the_same_motion():
    """What is read every tick, against the arrays: before, in every piece, and behind the end."""
    plan = PLANNER.begin(STANCE, steps_along(FEET, STANCE, Stride(0.2, 0.02, 0.1), 4))
    for t in np.linspace(-0.1, plan.end + 0.1, 301):
        state = plan.centre.at(t)
        assert np.allclose(plan.centre.motion(t), [*state.p, *state.v], rtol=0.0, atol=1e-12)
