"""Trajectories: through their waypoints, at rest where they say, and their rate is their rate."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import PPoly, make_interp_spline

from equipoise.errors import InputError
from equipoise.spatial import pose
from equipoise.trajectories import (
    AttachedTrajectory,
    Travel,
    Waypoint,
    WaypointTrajectory,
)
from equipoise.trajectories.quintic import quintic_powers

WAYPOINTS = [
    Waypoint(0.5, pose((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))),
    Waypoint(1.5, pose((0.3, 0.1, 0.0), (0.0, 0.5, 1.0))),
    Waypoint(2.0, pose((0.4, 0.4, 0.2), (0.2, 0.5, 2.0)), stop=True),
    Waypoint(3.5, pose((0.0, 0.5, 0.2), (0.2, -0.5, 3.0))),
]


@pytest.mark.parametrize("waypoint", WAYPOINTS)
def test_passes_through_every_waypoint(waypoint):
    sample = WaypointTrajectory(WAYPOINTS).at(waypoint.t)
    assert np.allclose(sample.T_world_target.homogeneous, waypoint.T_world_target.homogeneous)


@pytest.mark.parametrize("t", [0.0, 0.5, 2.0, 3.5, 9.0])
def test_rests_at_the_ends_and_at_stops(t):
    assert np.abs(WaypointTrajectory(WAYPOINTS).at(t).twist_world).max() < 1e-9


@pytest.mark.parametrize("t", [0.7, 1.5, 1.9, 2.3, 3.2])
@pytest.mark.parametrize("offset", [pin.SE3.Identity(), pose((0.1, 0.2, 0.3), (0.4, 0.5, 0.6))])
def test_twist_is_the_rate_of_the_pose(t, offset):
    way = AttachedTrajectory(WaypointTrajectory(WAYPOINTS), offset)
    h = 1e-6
    ahead, behind = way.at(t + h).T_world_target, way.at(t - h).T_world_target
    linear = (ahead.translation - behind.translation) / (2 * h)
    angular = pin.log3(ahead.rotation @ behind.rotation.T) / (2 * h)
    assert np.allclose(way.at(t).twist_world, np.concatenate((linear, angular)), atol=1e-6)


def test_two_waypoints_give_the_minimum_jerk_polynomial():
    way = WaypointTrajectory([Waypoint(0.0, pose((0, 0, 0))), Waypoint(2.0, pose((1, 0, 0)))])
    for x in np.linspace(0, 1, 11):
        expected = x**3 * (10 - 15 * x + 6 * x * x)
        assert way.at(2.0 * x).T_world_target.translation[0] == pytest.approx(expected, abs=1e-12)


def test_no_other_smooth_way_has_less_jerk():
    """Add any smooth bump that vanishes with two derivatives at rests and at the middle point."""
    points = [
        Waypoint(0.0, pose((0, 0, 0))),
        Waypoint(1, pose((1, 0, 0))),
        Waypoint(2, pose((0, 0, 0))),
    ]
    way = WaypointTrajectory(points)
    t = np.linspace(0.0, 2.0, 4001)
    x = np.array([way.at(s).T_world_target.translation[0] for s in t])
    bump = (t * (2 - t)) ** 4 * (t - 1)

    def cost(y):
        return np.sum(np.diff(y, 3)[5:-5] ** 2)

    assert cost(x) < cost(x + 0.02 * bump)
    assert cost(x) < cost(x - 0.02 * bump)


def test_rotation_beyond_half_a_turn_keeps_its_way():
    """Steps of 2 rad about one axis: the middle of the second step is at 3 rad, not behind."""
    way = WaypointTrajectory(
        [Waypoint(float(k), pose((0, 0, 0), (0, 0, 2.0 * k)), stop=True) for k in range(4)]
    )
    R = way.at(1.5).T_world_target.rotation
    assert np.allclose(R, pose((0, 0, 0), (0, 0, 3.0)).rotation, atol=1e-9)


def test_times_must_increase():
    with pytest.raises(InputError, match="increase"):
        WaypointTrajectory([Waypoint(1.0, pose((0, 0, 0))), Waypoint(1.0, pose((1, 0, 0)))])


@settings(max_examples=60, deadline=None)
@given(st.integers(2, 9), st.integers(0, 2**32 - 1))
def test_the_spline_is_the_one_that_scipy_finds(count, seed):
    """Quintic, at rest at both ends, four derivatives continuous: there is only one."""
    rng = np.random.default_rng(seed)
    times, points = np.cumsum(rng.uniform(0.2, 2.0, size=count)), rng.normal(size=(count, 6))
    powers = quintic_powers(times, points)
    rest = [(1, np.zeros(6)), (2, np.zeros(6))]
    theirs = make_interp_spline(times, points, k=5, bc_type=(rest, rest))
    ours = PPoly(powers.transpose(1, 0, 2), times)
    asked = np.linspace(times[0], times[-1], 200)
    assert np.allclose(ours(asked), theirs(asked), atol=1e-9 * np.abs(theirs(asked)).max())


def test_impossible_travels_and_waypoints_are_refused():
    nowhere = pin.SE3(np.eye(3), np.array([np.nan, 0.0, 0.0]))
    with pytest.raises(InputError, match="finite"):
        WaypointTrajectory([Waypoint(0.0, nowhere)])
    with pytest.raises(InputError, match="end after it starts"):
        Travel(1.0, 1.0, 0.1)
