"""Swings, glides, the clock and tracks: smooth, and where they should be."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from equipoise.errors import InputError
from equipoise.walking.clock import WalkClock
from equipoise.walking.feet import level_pose
from equipoise.walking.landing import Glide, Probe
from equipoise.walking.swing import Swing, SwingShape
from equipoise.walking.tracks import Track

FROM = level_pose(0.1, 0.09, 0.0, 0.2)
SHAPE = SwingShape(0.06, 0.05, 0.03)


def a_swing(z=0.05):
    return Swing(FROM, level_pose(0.5, 0.12, z, 0.6), 1.0, 1.8, SHAPE)


def body(sample):
    return sample.T_world_sole, sample.twist, sample.acceleration


@pytest.mark.parametrize(
    ("path", "begin"),
    [
        (a_swing(), 1.0),
        (Glide(a_swing().at(1.79), FROM, 1.79, 0.12, 0.04, 0.1), 1.79),
        (Probe(a_swing().at(1.6), 1.6, 0.04, 0.05, 1.0), 1.6),
    ],
)
def test_twist_is_the_rate_of_the_pose_and_has_no_jump(path, begin):
    h = 1e-5
    for t in np.linspace(begin + 2e-5, begin + 0.4, 400):
        (T0, *_), (_, twist, _), (T1, *_) = (body(path.at(t + d)) for d in (-h, 0.0, h))
        rate = (T1.translation - T0.translation) / (2.0 * h)
        turn = pin.log3(T1.rotation @ T0.rotation.T) / (2.0 * h)
        assert np.allclose(twist[:3], rate, atol=2e-4)
        assert np.allclose(twist[3:], turn, atol=2e-4)


def test_a_swing_is_twice_continuously_differentiable():
    """Finite differences of the twist are the acceleration, and that one has no jump."""
    swing, h = a_swing(), 1e-6
    times = np.linspace(0.95, 1.82, 2000)
    for t in times:
        change = (swing.at(t + h).twist - swing.at(t - h).twist) / (2.0 * h)
        assert np.allclose(change, swing.at(t).acceleration, atol=1e-3)
    accelerations = np.array([swing.at(t).acceleration for t in times])
    assert np.abs(np.diff(accelerations, axis=0)).max() < 0.4


def test_a_swing_goes_up_over_the_higher_end_and_comes_down_softly():
    for z in (-0.05, 0.0, 0.05):
        swing = a_swing(z)
        heights = [swing.at(t).T_world_sole.translation[2] for t in np.linspace(1.0, 1.8, 801)]
        assert max(heights) == pytest.approx(max(z, 0.0) + SHAPE.height, abs=1e-4)
        down = swing.at(1.8)
        assert np.allclose(down.T_world_sole.homogeneous, swing.T_to.homogeneous, atol=1e-12)
        assert np.allclose(down.twist, [0, 0, -SHAPE.touchdown, 0, 0, 0], atol=1e-12)


def test_it_searches_straight_down_for_as_far_as_it_is_told():
    swing = a_swing(0.0)
    behind = swing.at(1.8 + 0.2)
    assert behind.T_world_sole.translation[2] == pytest.approx(-0.01)
    assert np.allclose(behind.T_world_sole.translation[:2], swing.T_to.translation[:2])
    far = swing.at(10.0)
    assert far.T_world_sole.translation[2] == pytest.approx(-SHAPE.search)
    assert np.abs(far.twist).max() == 0.0


def test_a_foot_that_landed_stops_by_half_of_its_way_and_stays_until_its_load_comes():
    begin = a_swing().at(1.6)
    path = Glide(begin, FROM, 1.6, 0.12, 0.04, 0.1)
    there = begin.T_world_sole.translation + 0.5 * 0.04 * begin.twist[:3]
    for t in (1.64, 1.7, 1.74):
        assert np.allclose(path.at(t).T_world_sole.translation, there, atol=1e-12)
        assert np.abs(path.at(t).twist).max() < 1e-12
    for t in (path.rests_from, 2.0):
        assert np.allclose(path.at(t).T_world_sole.homogeneous, FROM.homogeneous, atol=1e-12)


def test_a_foot_that_came_off_goes_straight_down_as_far_as_it_is_told():
    path = Probe(a_swing().at(1.6), 1.6, 0.04, 0.05, 0.02)
    slow = path.at(path.slow_from).T_world_sole.translation
    assert np.allclose(path.at(path.slow_from + 0.2).twist, [0, 0, -0.05, 0, 0, 0], atol=1e-12)
    for t, gone in ((0.2, 0.01), (5.0, 0.02)):
        here = path.at(path.slow_from + t).T_world_sole.translation
        assert np.allclose(here, slow - [0.0, 0.0, gone], atol=1e-12)
    assert np.abs(path.at(9.0).twist).max() == 0.0


def test_the_greatest_speed_and_acceleration_across_are_the_formulas():
    swing = a_swing()
    samples = [swing.at(t) for t in np.linspace(1.0, 1.8, 4001)]
    speeds = [np.linalg.norm(one.twist[:2]) for one in samples]
    sharp = [np.linalg.norm(one.acceleration[:2]) for one in samples]
    assert swing.fastest == pytest.approx(max(speeds), rel=1e-4)
    assert swing.sharpest == pytest.approx(max(sharp), rel=1e-4)


def test_the_clock_keeps_time_rate_and_its_derivative_smooth():
    clock, dt = WalkClock(2.0), 1e-4
    times, rates = [], []
    for k in range(10000):
        clock.slowed = 2000 <= k < 5000
        before = clock.t
        rate = clock.rate
        clock.advance(dt)
        assert clock.t - before == pytest.approx(0.5 * (rate + clock.rate) * dt, rel=1e-4)
        times.append(clock.t)
        rates.append(clock.rate)
    bends = np.diff(rates) / dt
    assert np.abs(np.diff(bends)).max() < 0.15  # its own rate is bounded: no jump
    assert (np.diff(times) > 0.0).all()
    assert min(rates) >= clock.least - 1e-12
    assert rates[2000 + 1500] < clock.least + 0.06 * (1.0 - clock.least)  # behind 0.15 s
    assert rates[-1] == pytest.approx(1.0, abs=1e-4)


def test_a_clock_that_would_stand_is_refused():
    with pytest.raises(InputError, match="least rate"):
        WalkClock(least=0.0)


def test_a_track_goes_on_when_what_is_to_come_is_dropped():
    track = Track(0.1).then(0.0, 1.0, 0.2).then(0.5, 1.5, -0.1).then(2.0, 3.0, 0.3)
    assert track.final == pytest.approx(0.5)
    for t in (0.3, 0.7, 1.2, 1.7):
        kept = track.before(t)
        assert kept.at(t) == pytest.approx(track.at(t))
        for later in np.linspace(t, 2.0, 7):
            if t > 0.5:
                assert kept.at(later) == pytest.approx(track.at(later))
