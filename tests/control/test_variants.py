"""Super-twisting and the adaptive slope: times in which they reach, by hand against the kernels."""

from __future__ import annotations

import numpy as np
import pytest

from equipoise.control import ControlGains, SignFunction
from equipoise.control.passivity.manifolds import PostureManifold
from equipoise.errors import InputError

K_IP, LAYER = 2.0, 0.01


def manifold(root=0.0, adapt=0.0, growth_max=4.0):
    return PostureManifold(
        1, alpha=0.0, beta_p=1.0, k_ip=K_IP, sgn=SignFunction("sign", LAYER), bound=100.0,
        variants=(root, adapt, growth_max),
    )  # fmt: skip


def s_rp(part, s):
    """Return s_rp at s_qp = s: the manifold's own answer, begun from nothing."""
    return float(part.update(0.0, np.zeros(1), np.array([s]))[0])


def on_the_mode(part, guess):
    """Return the s_qp at which s_rp vanishes, by bisection over the manifold's own answer."""
    low, high = 0.0, guess
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if s_rp(part, middle) < 0.0 else (low, middle)
    return high


@pytest.mark.parametrize("root", [0.0, 0.3, 1.0])
def test_on_the_sliding_mode_the_root_delays_the_reach_by_what_it_carries(root):
    part, dt = manifold(root), 1e-3
    s0, s1 = 1.0, 0.2
    part.integral_of_sign = -(s_rp(part, s0)) / K_IP  # now s_rp(s0) = 0
    ticks = 0
    while on_the_mode(part, s0) > s1:
        part.integrate(dt, np.array([s0]), np.zeros(1))
        ticks += 1
    bare = manifold(root)
    expected = (s_rp(bare, s0) - s_rp(bare, s1)) / K_IP
    assert ticks * dt == pytest.approx(expected, abs=2 * dt)
    assert expected >= (s0 - s1) / K_IP  # at least the time of (26)


def test_the_root_is_odd_and_smooth_and_a_root_far_out():
    part, h = manifold(1.0), 1e-7
    root = lambda s: s_rp(part, s) - s  # noqa: E731
    assert root(-0.5) == pytest.approx(-root(0.5))
    assert root(4.0) == pytest.approx(2.0, rel=2e-3)
    assert (root(h) - root(-h)) / (2 * h) == pytest.approx(LAYER**-0.5, rel=1e-4)


def test_the_slope_grows_outside_the_layer_stops_and_comes_back():
    part, dt, adapt = manifold(adapt=10.0, growth_max=2.0), 1e-4, 10.0
    for k in range(3000):
        part.integrate(dt, np.array([1.0]), np.zeros(1))
        t = dt * (k + 1)
        assert part.growth[0] == pytest.approx(min(adapt * t, 2.0), abs=1e-9)
    t, full = 0.3, 2.0 / adapt
    by_hand = t + adapt * full**2 / 2 + 2.0 * (t - full)
    assert part.integral_of_sign[0] == pytest.approx(by_hand, rel=2e-3)
    for _ in range(2100):
        part.integrate(dt, np.array([0.0]), np.zeros(1))
    assert part.growth[0] == 0.0


def test_a_held_joint_does_not_grow():
    part = manifold(adapt=10.0)
    for _ in range(10):
        part.integrate(1e-3, np.array([1.0]), np.ones(1))
    assert part.growth[0] == 0.0
    assert part.integral_of_sign[0] == 0.0


@pytest.mark.parametrize("name", ["root", "adapt"])
def test_variants_without_a_layer_are_refused(name):
    with pytest.raises(InputError, match="layer"):
        ControlGains(K_d=1.0, sgn_p=SignFunction("sign", 0.0), **{name: 1.0})
    with pytest.raises(InputError, match=name):
        ControlGains(K_d=1.0, **{name: -1.0})
