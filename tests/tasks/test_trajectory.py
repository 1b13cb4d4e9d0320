"""Trajectories: through their waypoints, at rest where they say, and their rate is their rate."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import PPoly, make_interp_spline

from equipoise.collision.scene import Body, Shape
from equipoise.contacts import (
    GraspContact,
    SoleContact,
    StraightMotion,
    SurfaceContact,
)
from equipoise.contacts.surfaces import Plane
from equipoise.errors import InputError
from equipoise.physics.mujoco.objects import LooseObject
from equipoise.spatial import pose
from equipoise.trajectories import (
    AttachedTrajectory,
    FixedPose,
    Profile,
    Travel,
    TravelTrajectory,
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


def turned(degrees, axis=2, stop=False):
    """Return the angle turned about an axis, integrated, and the least rate, over waypoints."""
    poses = [pose((0, 0, 0), np.radians(d) * np.eye(3)[axis]) for d in degrees]
    way = WaypointTrajectory([Waypoint(float(k), T, stop) for k, T in enumerate(poses)])
    t = np.linspace(0, len(degrees) - 1, 2001)
    rate = np.degrees([way.row(x)[15 + axis] for x in t])
    return np.trapezoid(rate, t), rate


@pytest.mark.parametrize("stop", [False, True])
@pytest.mark.parametrize("axis", [0, 2])
@pytest.mark.parametrize(
    "degrees",
    [
        [0, 90, 180, 270, 360],
        [0, -90, -180, -270, -360],
        [0, 120, 240, 360, 480, 600, 720],
        [30, 150, 270, 390],
        [0, 179, 358, 537],
        [0, 90, 180, 360, 450],
        [0, 180, 360],
        [0, 180, 270, 360],
        [0, -180, -270],
        [10, 10, 100, 190, 280, 370],
    ],
)
def test_whole_turns_by_several_waypoints_are_turned(degrees, axis, stop):
    total, rate = turned(degrees, axis, stop)
    wanted = degrees[-1] - degrees[0]
    assert abs(total) == pytest.approx(abs(wanted), abs=0.5)
    if degrees not in ([0, 180, 360],):  # half turns alone go either way, but on
        assert total == pytest.approx(wanted, abs=0.5)
    if min(np.abs(np.diff(degrees))) > 0:  # uneven legs overshoot, even ones do not
        assert (np.sign(wanted) * rate).min() > -1.0 or len(set(np.diff(degrees))) > 1


def test_a_half_turn_there_and_back_comes_back():
    assert turned([0, 90, 0])[0] == pytest.approx(0.0, abs=0.5)
    assert turned([0, 200, 0], stop=True)[0] == pytest.approx(0.0, abs=0.5)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.booleans())
def test_each_leg_between_rests_goes_the_short_way(seed, stop):
    """At rest at both ends, a leg turns about one axis by the angle between its two rotations."""
    rng = np.random.default_rng(seed)
    rotations = [pin.exp3(rng.normal(size=3) * 2.0) for _ in range(5)]
    poses = [pin.SE3(R, rng.normal(size=3)) for R in rotations]
    way = WaypointTrajectory([Waypoint(float(k), T, True) for k, T in enumerate(poses)])
    for k in range(4):
        t = np.linspace(k, k + 1, 401)
        speed = [np.linalg.norm(way.row(x)[15:]) for x in t]
        angle = np.linalg.norm(pin.log3(rotations[k].T @ rotations[k + 1]))
        assert np.trapezoid(speed, t) == pytest.approx(angle, abs=1e-3)
        assert angle <= np.pi


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_rotation_through_waypoints_is_smooth(seed):
    """Through every waypoint; angular velocity and acceleration from both sides are the same."""
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.uniform(0.5, 1.5, size=6))
    poses = [pin.SE3(pin.exp3(rng.normal(size=3)), rng.normal(size=3)) for _ in times]
    way = WaypointTrajectory([Waypoint(t, T) for t, T in zip(times, poses, strict=True)])
    h = 1e-5
    for t, T in zip(times[1:-1], poses[1:-1], strict=True):
        assert np.allclose(way.at(t).T_world_target.homogeneous, T.homogeneous, atol=1e-9)
        before, here, after = (way.at(x).twist_world[3:] for x in (t - h, t, t + h))
        scale = 1.0 + np.abs(here).max()
        assert np.allclose(before, after, atol=1e-2 * scale)
        bend = [(way.at(t + s * h).twist_world[3:] - here) / (s * h) for s in (-1, 1)]
        assert np.allclose(bend[0], bend[1], atol=2e-2 * (1.0 + np.abs(bend[0]).max()))


def test_turned_waypoints_give_the_turned_way(rng):
    """Another world, or another frame on the body, changes nothing in how the body moves."""
    poses = [pin.SE3(pin.exp3(rng.normal(size=3)), rng.normal(size=3)) for _ in range(4)]
    world, tool = (pin.SE3(pin.exp3(rng.normal(size=3)), np.zeros(3)) for _ in range(2))
    ways = [
        WaypointTrajectory([Waypoint(float(k), A * T * B) for k, T in enumerate(poses)])
        for A, B in ((pin.SE3.Identity(), pin.SE3.Identity()), (world, tool))
    ]
    for t in np.linspace(0.1, 2.9, 15):
        plain, other = (way.at(t).T_world_target for way in ways)
        assert np.allclose(other.rotation, (world * plain * tool).rotation, atol=1e-9)


MIRROR = np.diag([1.0, 1.0, -1.0])
NO_POSES = {
    "mirrored": pin.SE3(MIRROR, np.zeros(3)),
    "turned inside out": pin.SE3(-np.eye(3), np.zeros(3)),
    "stretched": pin.SE3(2.0 * np.eye(3), np.zeros(3)),
    "nothing": pin.SE3(np.zeros((3, 3)), np.zeros(3)),
    "sheared": pin.SE3(np.eye(3) + 1e-3 * np.eye(3, k=1), np.zeros(3)),
    "nan": pin.SE3(np.eye(3), np.array([np.nan, 0.0, 0.0])),
    "nan rotation": pin.SE3(np.full((3, 3), np.nan), np.zeros(3)),
    "inf": pin.SE3(np.eye(3), np.array([0.0, np.inf, 0.0])),
    "huge": pin.SE3(np.eye(3), np.array([0.0, 0.0, 1e200])),
    "a matrix": np.eye(4),
    "none": None,
}

POSE_TAKERS = {
    "FixedPose": lambda robot, T: FixedPose(T),
    "Waypoint": lambda robot, T: WaypointTrajectory([Waypoint(0.0, T)]),
    "AttachedTrajectory": lambda robot, T: AttachedTrajectory(FixedPose(pose((0, 0, 0))), T),
    "SoleContact": lambda robot, T: SoleContact(name="s", sole=robot.soles[0], T_world_anchor=T),
    "GraspContact": lambda robot, T: GraspContact(
        name="g", frame_a="left_palm", frame_b="right_palm", T_a_b=T
    ),
    "SurfaceContact": lambda robot, T: SurfaceContact(
        name="c", frame="left_palm", surface=Plane(), T_world_surface=T
    ),
    "StraightMotion": lambda robot, T: StraightMotion(T, (1.0, 0.0, 0.0), Travel(0.0, 1.0, 1.0)),
    "Shape": lambda robot, T: Shape("box", (1.0, 1.0, 1.0), T),
    "Body": lambda robot, T: Body("b", (), T),
    "LooseObject": lambda robot, T: LooseObject(Body("b", (), pose((0, 0, 0))), 1.0, 0.5, T),
}


@pytest.mark.parametrize("case", NO_POSES)
@pytest.mark.parametrize("make", POSE_TAKERS.values(), ids=POSE_TAKERS)
def test_what_is_no_pose_is_refused_everywhere(hrp2, case, make):
    with pytest.raises(InputError) as caught:
        make(hrp2, NO_POSES[case])
    assert caught.value.remedy or caught.value.given is not None


def test_single_precision_is_precise_enough(rng):
    R = pin.exp3(rng.normal(size=3)).astype(np.float32).astype(float)
    assert np.isfinite(FixedPose(pin.SE3(R, np.ones(3))).row(0.0)).all()


HERE, THERE = pose((0, 0, 0)), pose((1, 0, 0))
NO_WAYS = {
    "no waypoints": lambda: WaypointTrajectory([]),
    "no time": lambda: WaypointTrajectory([Waypoint("0", HERE)]),
    "nan time": lambda: WaypointTrajectory([Waypoint(np.nan, HERE)]),
    "endless": lambda: WaypointTrajectory([Waypoint(np.inf, HERE)]),
    "too late": lambda: WaypointTrajectory([Waypoint(1e308, HERE)]),
    "at once": lambda: WaypointTrajectory([Waypoint(1, HERE), Waypoint(1, THERE)]),
    "too close": lambda: WaypointTrajectory([Waypoint(0, HERE), Waypoint(1e-9, THERE)]),
    "back in time": lambda: WaypointTrajectory([Waypoint(1, HERE), Waypoint(0, THERE)]),
    "no travel": lambda: Travel(1.0, 1.0, 0.1),
    "travel of a moment": lambda: Travel(1.0, 1.0 + 1e-12, 0.1),
    "travel to nowhere": lambda: Travel(0.0, 1.0, np.nan),
    "travelling at once": lambda: TravelTrajectory(FixedPose(HERE), np.eye(3)[0], 1.0, 1.0, 0.1),
    "travelling along nothing": lambda: TravelTrajectory(
        FixedPose(HERE), np.zeros(3), Travel(0.0, 1.0, 1.0)
    ),
    "travelling nowhere": lambda: TravelTrajectory(
        FixedPose(HERE), np.array([np.nan, 0, 0]), Travel(0.0, 1.0, 1.0)
    ),
    "travelling without a body": lambda: TravelTrajectory(
        HERE, np.eye(3)[0], Travel(0.0, 1.0, 1.0)
    ),
    "attached to a pose": lambda: AttachedTrajectory(HERE, THERE),
    "profile of nothing": lambda: Profile((), ()),
    "profile at once": lambda: Profile((0.0, 0.0), (1.0, 2.0)),
    "profile of nan": lambda: Profile((0.0, 1.0), (1.0, np.nan)),
    "profile of words": lambda: Profile((0.0, 1.0), ("a", "b")),
    "asked at nan": lambda: FixedPose(HERE).at(np.nan),
    "a way asked at nan": lambda: WaypointTrajectory([Waypoint(0, HERE)]).row(np.nan),
    "pose of two numbers": lambda: pose((0.0, 1.0)),
    "pose of nan": lambda: pose((0.0, np.nan, 0.0)),
    "pose of words": lambda: pose(("a", "b", "c")),
    "nan angle": lambda: pose((0, 0, 0), (np.inf, 0, 0)),
}


@pytest.mark.parametrize("case", NO_WAYS)
def test_what_is_no_way_is_refused(case):
    with pytest.raises(InputError):
        NO_WAYS[case]()


def test_a_way_is_held_before_and_after_for_ever():
    way = WaypointTrajectory([Waypoint(0.0, HERE), Waypoint(1.0, THERE)])
    for t, T in ((-np.inf, HERE), (-1e300, HERE), (np.inf, THERE), (1e300, THERE)):
        assert np.allclose(way.at(t).T_world_target.homogeneous, T.homogeneous)
        assert np.array_equal(way.at(t).twist_world, np.zeros(6))


@pytest.mark.parametrize(
    "times", [[0, 1e-4, 1e9], [0, 1e-4, 1e5, 1e5 + 1e-4], [0, 1, 1 + 1e-4, 2, 1e3], [-1e9, 1e9]]
)
def test_legs_of_very_different_length_are_travelled(times):
    poses = [pose((k, 0, 0), (0, 0, 1.5 * k)) for k in range(len(times))]
    way = WaypointTrajectory([Waypoint(float(t), T) for t, T in zip(times, poses, strict=True)])
    for t, T in zip(times, poses, strict=True):
        found = way.at(float(t)).T_world_target
        assert np.allclose(found.homogeneous, T.homogeneous, atol=1e-6)
