"""Ways slowed to what is allowed: bounds and poses are kept, and so is what is slow enough."""

from __future__ import annotations

import numpy as np
import pytest

from equipoise.errors import InputError
from equipoise.spatial import pose
from equipoise.trajectories import MotionLimits, Waypoint, WaypointTrajectory, slow_down


def random_way(rng, count):
    times = np.cumsum(rng.uniform(0.2, 1.5, count))
    return [
        Waypoint(float(t), pose(rng.uniform(-1.0, 1.0, 3), rng.uniform(-1.0, 1.0, 3)), stop)
        for t, stop in zip(times, rng.random(count) < 0.3, strict=True)
    ]


def peaks(way):
    """Return speed, acceleration, turn and turn acceleration at most, from much finer samples."""
    trajectory, times = WaypointTrajectory(way), [w.t for w in way]
    at = np.linspace(times[0], times[-1], 4001)
    twists = np.array([trajectory.row(t)[12:] for t in at])
    rates = np.diff(twists, axis=0) / (at[1] - at[0])
    return [
        float(np.linalg.norm(x[:, s], axis=1).max())
        for s in (slice(0, 3), slice(3, 6))
        for x in (twists, rates)
    ]


@pytest.mark.parametrize("seed", range(12))
def test_limits_are_kept_and_poses_stay(seed):
    rng = np.random.default_rng(seed)
    way = random_way(rng, int(rng.integers(2, 6)))
    limits = MotionLimits(*(float(10 ** rng.uniform(-1.0, 0.5)) for _ in range(4)))
    slowed, legs = slow_down(way, limits)
    speed, acceleration, turn, turn_acceleration = peaks(slowed)
    assert speed <= limits.speed * 1.01
    assert acceleration <= limits.acceleration * 1.02
    assert turn <= limits.turn * 1.01
    assert turn_acceleration <= limits.turn_acceleration * 1.02
    assert [w.T_world_target for w in slowed] == [w.T_world_target for w in way]
    assert [w.stop for w in slowed] == [w.stop for w in way]
    given, taken = np.diff([w.t for w in way]), np.diff([w.t for w in slowed])
    assert np.all(taken >= given * (1.0 - 1e-12))
    for leg in legs:
        assert leg.given == pytest.approx(given[leg.number - 1])
        assert leg.taken == pytest.approx(taken[leg.number - 1])


def test_one_leg_at_its_speed_limit_takes_what_minimum_jerk_takes():
    """The speed of a minimum-jerk leg peaks at 15/8 of its mean: 2 m at 1 m/s take 3.75 s."""
    way = [Waypoint(0.2, pose((0, 0, 0))), Waypoint(1.2, pose((2, 0, 0)))]
    slowed, legs = slow_down(way, MotionLimits(speed=1.0))
    assert slowed[0].t == 0.2
    assert slowed[1].t - slowed[0].t == pytest.approx(3.75, rel=2e-3)
    assert legs[0].sentence("right_palm") == "leg 1 of right_palm takes 3.75 s instead of 1 s"


def test_what_is_slow_enough_is_the_same_object():
    way = tuple(random_way(np.random.default_rng(2), 4))
    slowed, legs = slow_down(way, MotionLimits(speed=1e3, acceleration=1e3))
    assert slowed is way
    assert legs == ()
    assert slow_down(way, MotionLimits())[0] == way


def test_only_the_leg_that_is_too_fast_is_slowed():
    way = [
        Waypoint(0.0, pose((0, 0, 0)), True),
        Waypoint(1.0, pose((1, 0, 0)), True),
        Waypoint(4.0, pose((1, 0.1, 0)), True),
    ]
    slowed, legs = slow_down(way, MotionLimits(speed=0.5))
    assert [leg.number for leg in legs] == [1]
    assert slowed[2].t - slowed[1].t == pytest.approx(3.0)


@pytest.mark.parametrize("value", [0.0, -1.0, np.nan])
def test_a_limit_that_is_none_is_refused(value):
    with pytest.raises(InputError, match="turn acceleration must be finite and positive"):
        MotionLimits(turn_acceleration=value)
