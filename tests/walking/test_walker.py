"""The phases as they happen: late, early and missed landings, stopping, and going on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from walks import DT, FEET, PLANNER, SETTINGS, STANCE, mirrored, walk, walker_of

from equipoise.walking import (
    LEFT,
    RIGHT,
    Stride,
    WalkMode,
    WalkPlanner,
    WalkTiming,
    steps_along,
)
from equipoise.walking.footsteps import after

STEPS = steps_along(FEET, STANCE, Stride(0.2), 6)
SOLES, CENTRE, TORSO = slice(0, 2), 2, 3
PLACE, SPEED = slice(9, 12), slice(12, 15)


def kinds(walker, kind):
    return [one for one in walker.events if one.kind == kind]


def require_smooth(rows, most, sharpest):
    """Every target goes where its twist says, and no twist jumps."""
    for k in range(rows.shape[1]):
        place, speed = rows[:, k, PLACE], rows[:, k, SPEED]
        mean = 0.5 * (speed[1:] + speed[:-1])
        assert np.abs(np.diff(place, axis=0) / DT - mean).max() < most
        assert np.abs(np.diff(speed, axis=0)).max() / DT < sharpest


def test_a_walk_is_smooth_and_ends_where_its_steps_lead():
    walker = walker_of(PLANNER, STEPS)
    rows = walk(walker)
    assert len(kinds(walker, "lift")) == len(kinds(walker, "touch")) == 6
    require_smooth(rows, 5e-4, 15.0)
    end = after(STANCE, STEPS)
    for foot in (LEFT, RIGHT):
        assert np.allclose(rows[-1, foot, PLACE], end[foot].translation, atol=1e-6)
    middle = FEET.middle(end).translation
    assert np.allclose(rows[-1, CENTRE, PLACE], [*middle[:2], SETTINGS.height], atol=1e-6)


@pytest.mark.parametrize("height", [-0.008, -0.02, 0.01, 0.02])
def test_ground_that_is_lower_or_higher_is_found_and_taken(height):
    """Lower: the clock slows while the foot searches. Higher: it lands early. Nothing jumps."""
    walker = walker_of(PLANNER, STEPS)
    rates = []
    rows = walk(walker, ground=lambda step: height * (step.number == 2),
                each=lambda t: rates.append(walker.clock.rate))  # fmt: skip
    touch = kinds(walker, "touch")[1]
    assert touch.off[2] == pytest.approx(height, abs=1e-3)
    assert bool(kinds(walker, "late")) == (height < 0.0)
    assert (min(rates) < 0.9) == (height < 0.0)
    assert rates[-1] == pytest.approx(1.0, abs=1e-6)
    assert walker.stance[LEFT].translation[2] == pytest.approx(0.0, abs=1e-9)
    require_smooth(rows, 2e-3, 60.0)


def test_a_foot_that_lands_early_and_comes_off_goes_down_again():
    """Ground that is 2 cm higher throws it off once; then it is free, and the plan waits for it."""
    walker = walker_of(PLANNER, STEPS)

    def bounced():
        return LEFT if len(kinds(walker, "touch")) == 2 and not kinds(walker, "bounce") else None

    rows = walk(walker, ground=lambda step: (0.02 - 0.006 * bool(kinds(walker, "bounce")))
                * (step.number == 2), bounced=bounced)  # fmt: skip
    one = [event for event in walker.events if event.step == 2]
    assert [event.kind for event in one] == ["lift", "touch", "bounce", "touch"]
    assert one[1].early > one[3].early
    assert one[2].t - one[1].t == pytest.approx(walker.touch.bounce, abs=2 * DT)
    assert len(kinds(walker, "lift")) == 6
    third = kinds(walker, "lift")[2].t
    assert third >= one[3].t + one[3].early + SETTINGS.timing.double - 2 * DT
    require_smooth(rows, 2e-3, 60.0)


def test_a_foot_that_lands_when_it_should_is_not_let_go_again():
    """Just before the load goes over it is too late, whatever the sensor says."""
    walker = walker_of(PLANNER, STEPS)
    walk(walker, bounced=lambda: LEFT if len(kinds(walker, "touch")) == 2 else None)
    assert not kinds(walker, "bounce")


def test_errors_of_landings_do_not_grow(rng):
    """However far each foot is off, the last one is off by its own error alone."""
    misses = rng.uniform(-0.008, 0.008, size=(13, 3)) * [1.0, 1.0, 0.0]
    steps = steps_along(FEET, STANCE, Stride(0.2), 12)
    walker = walker_of(PLANNER, steps)
    rows = walk(walker, miss=lambda step: misses[step.number])
    off = [one.off for one in kinds(walker, "touch")]
    assert np.allclose(off, misses[1:], atol=1e-3)
    require_smooth(rows, 2e-3, 25.0)


@pytest.mark.parametrize("moment", [0.2, 1.7, 2.0, 2.5, 3.0, 4.2])
def test_it_stops_at_any_time_with_its_feet_side_by_side(moment):
    walker = walker_of(PLANNER, STEPS)
    stopped = []

    def each(t):
        if t >= moment and not stopped:
            stopped.append(len(kinds(walker, "lift")))
            walker.stop()

    rows = walk(walker, each=each)
    assert len(kinds(walker, "lift")) <= stopped[0] + 2
    beside = STANCE[RIGHT].actInv(STANCE[LEFT]).homogeneous
    assert np.allclose(
        walker.stance[RIGHT].actInv(walker.stance[LEFT]).homogeneous, beside, atol=1e-6
    )
    require_smooth(rows, 5e-4, 15.0)


def test_it_walks_on_with_other_steps_and_from_a_stand():
    walker = walker_of(PLANNER, steps_along(FEET, STANCE, Stride(0.2), 3))
    walk(walker)
    stance = walker.stance
    there = steps_along(FEET, stance, Stride(turn=0.1), 4)
    walker.walk_on(there)
    rows = []
    t = 20.0
    for _ in range(6000):
        soles = tuple(led.at(t).T_world_target for led in walker.targets.soles)
        step = walker.swinging
        loads = [250.0, 250.0]
        if step is not None:
            loads[step.foot] = 500.0 if soles[step.foot].translation[2] <= 1e-12 else 0.0
        walker.advance(t, DT, loads, lambda soles=soles: soles)
        targets = walker.targets
        led = (*targets.soles, targets.centre, targets.upright["torso"])
        rows.append([one.row(t).copy() for one in led])
        t += DT
    rows = np.array(rows)
    require_smooth(rows, 5e-4, 15.0)
    for foot in (LEFT, RIGHT):
        assert np.allclose(
            walker.stance[foot].homogeneous, after(stance, there)[foot].homogeneous, atol=1e-6
        )
    R = rows[-1, TORSO, :9].reshape(3, 3).T
    assert pin.log3(R)[2] == pytest.approx(0.4, abs=1e-6)
    spin, angles = (
        rows[:, TORSO, 17],
        [pin.log3(row[:9].reshape(3, 3).T)[2] for row in rows[:, TORSO]],
    )
    assert np.abs(np.diff(angles) / DT - 0.5 * (spin[1:] + spin[:-1])).max() < 1e-3


def test_a_walk_in_the_mirror_is_the_mirrored_walk():
    swapped = (mirrored(STANCE[RIGHT]), mirrored(STANCE[LEFT]))
    one = walk(walker_of(PLANNER, steps_along(FEET, STANCE, Stride(0.1, 0.03, 0.1), 4)))
    other = walk(
        walker_of(PLANNER, steps_along(FEET, swapped, Stride(0.1, -0.03, -0.1), 4), swapped)
    )
    flip = np.array([1.0, -1.0, 1.0])
    for k, j in ((0, 1), (1, 0), (CENTRE, CENTRE)):
        assert np.allclose(one[:, k, PLACE], flip * other[:, j, PLACE], atol=1e-9)


def test_slow_steps_stand_still_over_a_foot_while_the_other_swings():
    slow = replace(SETTINGS, mode=WalkMode.SLOW, timing=WalkTiming(1.0, shift=2.0))
    walker = walker_of(WalkPlanner(FEET, slow), STEPS[:2])
    off = []

    def each(t):
        if walker.swinging is not None:
            foot = 1 - walker.swinging.foot
            p = walker.targets.centre.at(t).T_world_target.translation[:2]
            off.append(np.abs(p - FEET.centre(foot, walker.stance[foot])[:2]).max())

    walk(walker, each=each)
    assert len(off) > 900
    assert max(off) < 1e-9


def test_a_foot_that_finds_no_ground_goes_down_as_fast_as_it_lands_while_the_plan_waits():
    walker = walker_of(PLANNER, STEPS)
    walk(walker, ground=lambda step: -0.02 * (step.number == 2))
    late, touch = kinds(walker, "late")[0], kinds(walker, "touch")[1]
    assert touch.t - late.t == pytest.approx(0.02 / SETTINGS.swing.touchdown, abs=0.02)
    assert -touch.early < 0.4 * (touch.t - late.t)  # by the clock of the plan


SLOW = replace(SETTINGS, mode=WalkMode.SLOW, timing=WalkTiming(1.0, 0.4, 1.5, 0.5))


def lost_at(walker, share, foot):
    """Walk, and lose a foot at a share of the shift that follows the first touchdown."""
    found = []

    def each(t):
        touched = kinds(walker, "touch")
        shift = walker.planner.settings.timing.shift
        if touched and not found and t >= touched[0].t + share * shift:
            before = walker.plan
            found.extend([t, walker.lose(t, foot), walker.plan is before, walker.supports])

    return each, found


def test_a_foot_that_loses_its_ground_is_put_down_again_while_the_other_carries():
    """The centre of mass goes on smoothly, over the sole that carries, and the walk is ended."""
    walker = walker_of(WalkPlanner(FEET, SLOW), STEPS[:3])
    each, found = lost_at(walker, 0.1, STEPS[0].foot)
    points = []

    def watch(t):
        each(t)
        points.append((t, walker.plan.centre.at(walker.clock.t).zmp, walker.supports))

    rows = walk(walker, each=watch)
    lost, caught, _, supports = found
    assert caught
    assert supports == (1 - STEPS[0].foot,)
    require_smooth(rows, 5e-4, 15.0)
    sole = FEET.support(STANCE, supports)
    back = kinds(walker, "touch")[1].t
    alone = [zmp for t, zmp, carry in points if carry == supports and lost < t < back]
    assert min(sole.margin(zmp) for zmp in alone) > 0.0
    assert len(kinds(walker, "lost")) == 1
    assert len(kinds(walker, "touch")) == 4
    assert walker.put_down == 3
    assert walker.stands


@pytest.mark.parametrize(("settings", "share"), [(SLOW, 0.5), (SETTINGS, 0.1)])
def test_a_foot_that_is_lost_too_late_to_stand_on_the_other_changes_nothing(settings, share):
    """Half-way between the feet, and where it falls from foot to foot, one sole cannot hold it."""
    walker = walker_of(WalkPlanner(FEET, settings), STEPS[:2])
    each, found = lost_at(walker, share, STEPS[0].foot)
    walk(walker, each=each)
    assert found[1:] == [False, True, (LEFT, RIGHT)]
    assert not kinds(walker, "lost")
