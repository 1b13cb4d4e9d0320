"""What a walk carries along: where it is, and that it moves as its twist says."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pinocchio as pin
import pytest
from walks import DT, FEET, PLANNER, STANCE, WEIGHT, walk, walker_of

from equipoise.errors import InputError
from equipoise.trajectories import CarriedTrajectory, FixedPose, Waypoint, WaypointTrajectory
from equipoise.walking import LedPose, Stride, TouchSettings, Walker, steps_along
from equipoise.walking.feet import level_pose

HELD = pin.SE3(pin.utils.rotate("x", 0.3), np.array([0.4, 0.1, 0.9]))


def carrying(stride: Stride, **changes) -> tuple[Walker, list[np.ndarray]]:
    """Walk with something held; return the walker and the rows (18,) of what is held."""
    walker = walker_of(PLANNER, steps_along(FEET, STANCE, stride, 5))
    carrier = LedPose(pin.SE3.Identity())
    walker = Walker(
        walker.planner, walker.plan, TouchSettings(0.03 * WEIGHT),
        replace(walker.targets, carrier=carrier),
    )  # fmt: skip
    held, rows = CarriedTrajectory(carrier, FixedPose(HELD)), []
    walk(walker, each=lambda t: rows.append(held.row(t).copy()), **changes)
    return walker, rows


@pytest.mark.parametrize(
    "stride", [Stride(0.2), Stride(0.1, 0.0, 0.15), Stride(0.0, 0.05, 0.0, 0.03)]
)
def test_what_is_held_goes_where_the_body_goes(stride):
    """Rigidly with the middle of the feet in the end; in between with its twist."""
    walker, rows = carrying(stride)
    start, end = FEET.middle(STANCE), FEET.middle(walker.stance)
    wanted = end * start.inverse() * HELD
    last = pin.SE3(rows[-1][:9].reshape(3, 3).T.copy(), rows[-1][9:12].copy())
    assert np.allclose(last.homogeneous, wanted.homogeneous, atol=1e-5)
    places = np.array(rows)
    mean = 0.5 * (places[1:, 12:15] + places[:-1, 12:15])
    assert np.abs(np.diff(places[:, 9:12], axis=0) / DT - mean).max() < 1e-3
    spin = 0.5 * (places[1:, 17] + places[:-1, 17])
    turned = [pin.log3(b[:9].reshape(3, 3).T @ a[:9].reshape(3, 3))[2] for a, b in pairwise(rows)]
    assert np.abs(np.array(turned) / DT - spin).max() < 1e-3


def test_nothing_jumps_where_the_ground_is_elsewhere():
    """A late and a missed landing: the plan is made anew, and what is held goes on smoothly."""
    miss = np.array([0.01, -0.005, 0.0])
    _, rows = carrying(
        Stride(0.15), ground=lambda step: -0.01 * (step.number == 2),
        miss=lambda step: miss * (step.number == 3),
    )  # fmt: skip
    speed = np.array(rows)[:, 12:15]
    assert np.abs(np.diff(speed, axis=0)).max() / DT < 15.0


def test_the_twist_of_a_path_on_a_moving_carrier_is_its_rate():
    """Both move: against finite differences."""
    path = WaypointTrajectory(
        [Waypoint(0.0, HELD), Waypoint(1.0, HELD * level_pose(0.1, -0.2, 0.05, 0.7))]
    )
    carrier = WaypointTrajectory(
        [Waypoint(0.0, level_pose(0.0, 0.0, 0.0, 0.2)),
         Waypoint(1.2, level_pose(0.5, 0.3, 0.1, 1.1))]
    )  # fmt: skip
    carried = CarriedTrajectory(carrier, path)
    h = 1e-5
    for t in (0.2, 0.5, 0.9):
        before, after = (carried.at(t + dt).T_world_target for dt in (-h, h))
        twist = carried.at(t).twist_world
        rate = (after.translation - before.translation) / (2 * h)
        spin = pin.log3(after.rotation @ before.rotation.T) / (2 * h)
        assert np.allclose(twist, [*rate, *spin], atol=1e-6)
    with pytest.raises(InputError, match="carrier"):
        CarriedTrajectory(HELD, path)
