"""Balance feedback: its rate, what it recovers from, and that it leaves alone what is well."""

from __future__ import annotations

import math

import numpy as np
import pytest
from walks import FEET, SETTINGS, STANCE

from equipoise.contacts import SupportPolygon
from equipoise.walking import LEFT, RIGHT, BalanceFeedback, BalanceSettings
from equipoise.walking.balance import room_towards
from equipoise.walking.centre import CentreState

OMEGA = SETTINGS.omega
ZERO = np.zeros(2)
GROUND = FEET.support(STANCE, (LEFT, RIGHT))
HOME = FEET.middle(STANCE).translation[:2]
REST = CentreState(HOME, ZERO, ZERO, HOME, HOME)


def displaced(dt, dcm, gain=3.0, margin=0.01, leash=1e-9):
    """Return a feedback whose reference was dragged to a divergent component (2,) [m] off home."""
    feedback = BalanceFeedback(BalanceSettings(gain, margin, leash), OMEGA, dt)
    feedback.drag(REST, HOME, OMEGA * np.asarray(dcm))
    return feedback


def dcm_of(feedback):
    return feedback.p + feedback.v / OMEGA


@pytest.mark.parametrize("dt", [1e-3, 5e-3, 2e-2])
@pytest.mark.parametrize("gain", [1.0, 3.0, 8.0])
def test_unclipped_the_divergent_component_dies_out_at_the_gain(dt: float, gain: float) -> None:
    """Whatever the period is; and the centre of mass follows it home."""
    feedback = displaced(dt, [0.01, -0.004], gain)
    before = dcm_of(feedback)
    ticks = round(1.0 / dt)
    for _ in range(ticks):
        feedback.advance(HOME, GROUND)
    assert np.allclose(dcm_of(feedback), math.exp(-gain * ticks * dt) * before, rtol=1e-9)
    left = round(20.0 / dt)
    while feedback.acts and left:
        feedback.advance(HOME, GROUND)
        left -= 1
    assert left
    assert not feedback.p.any()


def test_between_ticks_it_is_the_pendulum() -> None:
    """Its acceleration is omega^2 (p - zmp), by differences of a tick so short as to be exact."""
    dt = 1e-4
    feedback = displaced(dt, [0.03, 0.01])
    for _ in range(2000):
        p, v = feedback.p, feedback.v
        feedback.advance(HOME, GROUND)
        a = OMEGA**2 * (0.5 * (p + feedback.p) - feedback.zmp)
        assert np.allclose((feedback.v - v) / dt, a, atol=1e-6)
        assert np.allclose((feedback.p - p) / dt, 0.5 * (v + feedback.v), atol=1e-6)


@pytest.mark.parametrize("angle", np.linspace(0.1, 6.2, 9))
@pytest.mark.parametrize(("share", "recovers"), [(0.97, True), (1.03, False)])
def test_what_is_inside_the_soles_is_recovered_and_nothing_else(
    angle: float, share: float, recovers: bool
) -> None:
    """In every direction: the divergent component within the margin comes back, beyond it not."""
    margin, dt = 0.01, 2e-3
    way = np.array([math.cos(angle), math.sin(angle)])
    edge = room_towards(GROUND, HOME, 10.0 * way, margin) * 10.0 * way
    feedback = displaced(dt, share * edge, margin=margin)
    for _ in range(round(6.0 / dt)):
        feedback.advance(HOME, GROUND)
        assert GROUND.margin(HOME + feedback.zmp) > margin - 1e-12
    assert (np.linalg.norm(dcm_of(feedback)) < 1e-4) == recovers


def test_a_bounded_push_is_recovered_as_its_impulse_says() -> None:
    """A robot that follows its reference, pushed from rest for 0.2 s: the bound in closed form.

    With the zero-moment point at the edge `a` from the start, an acceleration `u` is recovered up
    to u = omega^2 a / (1 - exp(-omega T)). The feedback begins at the middle, so it has less.
    """
    margin, dt, T = 0.01, 1e-3, 0.2
    edge = FEET.left.x_max - margin - HOME[0]
    most = OMEGA**2 * edge / (1.0 - math.exp(-OMEGA * T))

    def comes_back(u, gain):
        settings = BalanceSettings(gain, margin, 1e-9)
        feedback = BalanceFeedback(settings, OMEGA, dt)
        for k in range(4000):
            if k * dt < T - 1e-9:
                pushed = np.array([u * dt, 0.0])
                at = HOME + feedback.p
                feedback.drag(REST, at, feedback.v + pushed)
            feedback.advance(HOME, GROUND)
        return np.linalg.norm(dcm_of(feedback)) < 1e-3

    assert not comes_back(1.03 * most, 50.0)
    assert comes_back(0.95 * most, 50.0)
    assert not comes_back(0.95 * most, 0.5)
    assert comes_back(0.7 * most, 3.0)


def test_a_robot_on_its_leash_changes_nothing(rng) -> None:
    """To the last bit, however it trembles within it."""
    feedback = BalanceFeedback(BalanceSettings(leash=0.01), OMEGA, 1e-3)
    for _ in range(200):
        angle, length = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(0.0, 0.00999)
        dcm = length * np.array([math.cos(angle), math.sin(angle)])
        p = rng.uniform(-0.02, 0.02, size=2)
        feedback.drag(REST, HOME + p, OMEGA * (dcm - p))
        feedback.advance(HOME, GROUND)
        assert not feedback.acts
        assert feedback.p.tobytes() == feedback.v.tobytes() == ZERO.tobytes()


def test_a_drag_ends_at_the_leash(rng) -> None:
    feedback = BalanceFeedback(BalanceSettings(leash=0.01), OMEGA, 1e-3)
    for _ in range(20):
        p, v = rng.normal(size=(2, 2)) * 0.1
        feedback.drag(REST, HOME + p, v)
        assert np.linalg.norm(p + v / OMEGA - dcm_of(feedback)) == pytest.approx(0.01, rel=1e-9)


def test_a_plan_nearer_to_the_edge_than_the_margin_is_kept() -> None:
    """The feedback does not move it further out, and may move it in."""
    square = SupportPolygon.of_points(np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) * 0.1)
    start = np.array([0.095, 0.05])
    assert room_towards(square, start, np.array([0.05, 0.0]), 0.01) == 0.0
    assert room_towards(square, start, np.array([-0.05, 0.0]), 0.01) == 1.0
    assert room_towards(square, start, np.array([0.0, 0.08]), 0.01) == pytest.approx(0.5)
