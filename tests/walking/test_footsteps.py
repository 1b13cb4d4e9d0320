"""Footsteps: where they lead, beside and never across, and in the mirror."""

from __future__ import annotations

import numpy as np
import pytest
from walks import FEET, STANCE, mirrored

from equipoise.errors import InputError
from equipoise.walking import LEFT, RIGHT, Stride, StrideLimits, closing_step, steps_along, steps_to
from equipoise.walking.feet import turn_between, yaw_of
from equipoise.walking.footsteps import after


@pytest.mark.parametrize("count", [1, 2, 3, 4, 7, 12])
def test_it_ends_with_the_feet_side_by_side(count):
    for stride in (Stride(0.2), Stride(0.1, 0.05), Stride(0.1, turn=-0.1), Stride(up=0.05)):
        stance = after(STANCE, steps_along(FEET, STANCE, stride, count))
        start, end = STANCE[LEFT].actInv(STANCE[RIGHT]), stance[LEFT].actInv(stance[RIGHT])
        assert np.allclose(start.homogeneous, end.homogeneous, atol=1e-12)


def test_straight_steps_alternate_and_each_lands_a_stride_ahead_of_the_other():
    steps = steps_along(FEET, STANCE, Stride(0.2), 5)
    assert [one.foot for one in steps] == [RIGHT, LEFT, RIGHT, LEFT, RIGHT]
    ahead = [one.T_world_sole.translation[0] for one in steps]
    assert np.allclose(ahead, [0.2, 0.4, 0.6, 0.8, 0.8])


@pytest.mark.parametrize("stride", [Stride(left=0.04), Stride(left=-0.04), Stride(turn=0.1)])
def test_sideways_no_foot_comes_nearer_to_the_other_than_it_stood(stride):
    stance, apart = STANCE, STANCE[RIGHT].actInv(STANCE[LEFT]).translation[1]
    for step in steps_along(FEET, STANCE, stride, 6):
        stance = after(stance, [step])
        assert stance[RIGHT].actInv(stance[LEFT]).translation[1] > np.cos(0.3) * apart


def test_stairs_rise_by_as_much_a_step():
    heights = [
        s.T_world_sole.translation[2] for s in steps_along(FEET, STANCE, Stride(0.2, up=0.05), 4)
    ]
    assert np.allclose(heights, [0.05, 0.1, 0.15, 0.15])


@pytest.mark.parametrize(
    "goal", [(1.0, 0.5, 0.3), (-0.2, 0.1, -0.4), (0.0, -0.3, 0.0), (-2.0, 0.0, 3.0)]
)
def test_a_goal_is_reached_in_steps_within_their_limits(goal):
    limits = StrideLimits()
    steps = steps_to(FEET, STANCE, goal, limits)
    middle = FEET.middle(after(STANCE, steps))
    assert np.allclose(middle.translation[:2], goal[:2], atol=1e-9)
    assert abs(turn_between(yaw_of(middle), goal[2])) < 1e-9
    stance, own = STANCE, STANCE[RIGHT].actInv(STANCE[LEFT]).translation[1]
    for before, step in zip([None, *steps[:-1]], steps, strict=True):
        assert before is None or before.foot != step.foot  # it never puts down a foot twice
        stance = after(stance, [step])
        left = stance[RIGHT].actInv(stance[LEFT])
        assert abs(yaw_of(left)) <= limits.turn + 1e-9
        assert np.abs(left.translation[0]) <= limits.forward + own * np.sin(limits.turn)
        assert left.translation[1] >= 0.8 * own


def test_steps_in_the_mirror_are_the_steps_of_the_other_foot():
    swapped = (mirrored(STANCE[RIGHT]), mirrored(STANCE[LEFT]))
    one = steps_along(FEET, STANCE, Stride(0.1, 0.04, 0.1), 5)
    other = steps_along(FEET, swapped, Stride(0.1, -0.04, -0.1), 5)
    for a, b in zip(one, other, strict=True):
        assert a.foot == 1 - b.foot
        assert np.allclose(
            mirrored(a.T_world_sole).homogeneous, b.T_world_sole.homogeneous, atol=1e-12
        )


def test_closing_is_nothing_where_the_feet_are_closed():
    beside = STANCE[RIGHT].actInv(STANCE[LEFT])
    assert closing_step(FEET, STANCE, LEFT, beside) == []
    ahead = after(STANCE, steps_along(FEET, STANCE, Stride(0.2), 2)[:1])
    [step] = closing_step(FEET, ahead, LEFT, beside)
    assert np.allclose(step.T_world_sole.translation, [0.2, 0.095, 0.0])


def test_what_is_no_number_of_steps_is_refused():
    for count in (-1, 2.5, True, 10**6):
        with pytest.raises(InputError, match="number of steps"):
            steps_along(FEET, STANCE, Stride(0.1), count)
    with pytest.raises(InputError, match="steps away"):
        steps_to(FEET, STANCE, (1e4, 0.0, 0.0))
