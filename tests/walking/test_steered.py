"""A walk that is steered: it goes as far as its stick says, stops, and never asks too much."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from walks import DT, FEET, LEFT, PLANNER, RIGHT, SETTINGS, STANCE, WEIGHT, walker_of

from equipoise.errors import InputError
from equipoise.walking import (
    SteeredWalk,
    Stick,
    StickSchedule,
    StrideLimits,
    WalkMode,
    WalkPlanner,
    WalkTiming,
)
from equipoise.walking.feasible import is_feasible, zmp_room
from equipoise.walking.feet import turn_between, yaw_of
from equipoise.walking.stick import clipped

LIMITS = StrideLimits(0.2, 0.06, 0.25)
PLACE, SPEED = slice(9, 12), slice(12, 15)
SLOW = WalkPlanner(FEET, replace(SETTINGS, mode=WalkMode.SLOW, timing=WalkTiming(shift=2.2)))
FAST = WalkPlanner(FEET, replace(SETTINGS, timing=WalkTiming(single=0.4, double=0.15)))


def steered_of(planner=PLANNER, limits=LIMITS):
    walker = walker_of(planner, [])
    walker.plan = planner.begin(STANCE, [], -planner.begin(STANCE, []).end)
    return SteeredWalk(walker, limits)


def steer(steered, schedule, until=40.0):
    """Let a robot without a body walk on flat ground; return times, rows of its targets, phases."""
    walker, times, rows, phases = steered.walker, [], [], []
    last, t = schedule.moments[-1], 0.0
    while t < until and not (t > last and walker.stands):
        steered.stick = schedule.at(t)
        soles = [led.at(t).T_world_target for led in walker.targets.soles]
        loads, step = [0.5 * WEIGHT, 0.5 * WEIGHT], walker.swinging
        if step is not None:
            floor = step.footstep.T_world_sole.translation[2]
            low = soles[step.foot].translation[2] <= floor + 1e-12
            loads[step.foot] = WEIGHT if low else 0.0
        steered.advance(t, DT, loads, lambda soles=tuple(soles): soles)
        led = (*walker.targets.soles, walker.targets.centre)
        times.append(t)
        rows.append([one.row(t).copy() for one in led])
        phases.append(None if step is None else step.foot)
        t += DT
    return np.array(times), np.array(rows), phases


def require_smooth(rows):
    for k in range(rows.shape[1]):
        place, speed = rows[:, k, PLACE], rows[:, k, SPEED]
        mean = 0.5 * (speed[1:] + speed[:-1])
        assert np.abs(np.diff(place, axis=0) / DT - mean).max() < 2e-3
        assert np.abs(np.diff(speed, axis=0)).max() / DT < 30.0


def lifts(steered):
    return [one for one in steered.walker.events if one.kind == "lift"]


@pytest.mark.parametrize("planner", [PLANNER, FAST, SLOW], ids=["walk", "fast", "slow"])
@pytest.mark.parametrize(
    "stick",
    [Stick(0.05), Stick(-0.03), Stick(left=0.008), Stick(turn=-0.03), Stick(0.04, 0.004, 0.02)],
    ids=str,
)
def test_it_goes_as_far_as_its_stick_says(planner, stick):
    """Integral of the velocity over the steps that were made by it, within a step of each kind."""
    steered = steered_of(planner)
    _, rows, _ = steer(steered, StickSchedule([(0.1, stick), (12.0, Stick())]))
    require_smooth(rows)
    made = len(lifts(steered)) - 1  # the last one closes
    assert made >= 2
    T, duration = FEET.middle(steered.walker.stance), made * planner.period
    turned = stick.turn * duration
    heading = 0.5 * turned  # of the chord
    chord = np.sinc(0.5 * turned / math.pi) * duration
    ahead = chord * np.array([stick.forward, stick.left])
    c, s = math.cos(heading), math.sin(heading)
    wanted = np.array([c * ahead[0] - s * ahead[1], s * ahead[0] + c * ahead[1]])
    stride = planner.period * math.hypot(stick.forward, stick.left)
    off = np.linalg.norm(T.translation[:2] - FEET.middle(STANCE).translation[:2] - wanted)
    assert off < stride + 1e-3
    assert abs(turn_between(turned, yaw_of(T))) < abs(stick.turn) * planner.period + 1e-6
    assert not steered.clips
    assert steered.sentence == "It stands."


@pytest.mark.parametrize("planner", [PLANNER, FAST], ids=["walk", "fast"])
def test_it_may_be_steered_elsewhere_in_every_phase_of_a_step(planner):
    """The plan of every landing is one that can be balanced, and every target goes on smoothly."""
    period, single = planner.period, planner.settings.timing.single
    phases_seen = set()
    for share in np.arange(0.0, 1.0, 0.3):
        steered, t = steered_of(planner), 4.0 + share * period
        moments = [(0.1, Stick(0.12)), (t, Stick(-0.1, 0.02, 0.05)), (t + 3.3, Stick())]
        times, rows, phases = steer(steered, StickSchedule(moments))
        require_smooth(rows)
        assert times[-1] < 35.0
        for moment in (t, t + 3.3):
            phases_seen.add(phases[int(moment / DT)])
        beside = STANCE[RIGHT].actInv(STANCE[LEFT]).homogeneous
        stance = steered.walker.stance
        assert np.allclose(stance[RIGHT].actInv(stance[LEFT]).homogeneous, beside, atol=1e-6)
    assert phases_seen == {None, LEFT, RIGHT}
    assert single < period


@pytest.mark.parametrize("stick", [Stick(turn=0.05), Stick(left=0.02), Stick(1.1e-3)], ids=str)
def test_a_stop_where_the_feet_are_side_by_side_already_can_be_balanced(stick):
    """The centre of mass is on its way over the other foot, which makes a step on the spot."""
    for share in (0.1, 0.9, 1.4):
        steered = steered_of(FAST)
        steer(steered, StickSchedule([(0.1, stick), (4.0 + share * FAST.period, Stick())]))
        plan = steered.walker.plan  # that of the last landing
        least = min(room for _, room, _ in zmp_room(plan, FEET, FAST.settings))
        assert least > 0.02


def test_it_walks_on_from_a_stop_that_was_taken_back():
    """Held again before it stands: it goes on without standing, or comes to rest and begins."""
    for gap in (0.1, 1.0, 2.5):
        steered = steered_of()
        moments = [(0.1, Stick(0.1)), (5.0, Stick()), (5.0 + gap, Stick(0.1)), (12.0, Stick())]
        _, rows, _ = steer(steered, StickSchedule(moments))
        require_smooth(rows)
        late = [one for one in lifts(steered) if one.t > 8.5]
        assert len(late) >= 3


def test_a_tap_is_a_step():
    steered = steered_of()
    _, rows, _ = steer(steered, StickSchedule([(0.5, Stick(0.1)), (0.6, Stick())]))
    assert len(lifts(steered)) == 2
    assert rows[-1, RIGHT, 9] == pytest.approx(0.1 * PLANNER.period, abs=1e-3)


def test_what_is_too_far_for_a_step_is_cut_off_and_told():
    limits, period = StrideLimits(0.2, 0.06, 0.25), 1.25
    stick, words = clipped(Stick(0.4, -0.1, 1.0), limits, period)
    assert stick == Stick(0.16, -0.024, 0.1)
    assert "0.2 m forwards is what the legs reach, 0.5 m is wanted" in words
    assert "0.06 m to the right" in words
    assert "0.25 rad to the left is what the feet have room for, 2.5 rad" in words
    assert clipped(stick, limits, period) == (stick, "")
    for foot in (LEFT, RIGHT):  # a step within the limits: never across
        stride = stick.stride(foot, period)
        side = 1.0 if foot == LEFT else -1.0
        assert 0.0 <= side * stride.left <= limits.side + 1e-12
        assert 0.0 <= side * stride.turn <= limits.turn + 1e-12
    steered = steered_of()
    steer(steered, StickSchedule([(0.1, Stick(5.0)), (6.0, Stick(0.05)), (9.0, Stick())]))
    [told] = steered.clips
    assert "t = 0.100 s: step clipped" in str(told)
    assert steered.clip == ""


def test_a_change_that_cannot_be_balanced_at_once_is_made_in_several_steps():
    """Long quick steps are turned round; every plan that was taken keeps inside the soles."""
    steered = steered_of(FAST, StrideLimits(0.3, 0.08, 0.3))
    moments = [(0.1, Stick(0.5)), (5.0, Stick(-0.5)), (8.0, Stick())]
    goes, walker = [], steered.walker
    taken = walker.walk_on

    def walk_on(steps):
        goes.append(steered.goes.forward)
        taken(steps)

    walker.walk_on = walk_on
    _, rows, _ = steer(steered, StickSchedule(moments))
    require_smooth(rows)
    assert min(goes) == pytest.approx(-0.5)
    between = [one for one in goes if -0.49 < one < 0.49]
    assert between
    assert any("several steps" in one.words for one in steered.clips)
    plan = walker.planner.begin(STANCE, [])
    assert is_feasible(plan, FEET, FAST.settings, steered._checks, 2)


def test_a_stick_is_checked():
    with pytest.raises(InputError, match="how fast to walk"):
        Stick(math.nan)
    with pytest.raises(InputError, match="after the one before"):
        StickSchedule([(1.0, Stick()), (1.0, Stick(0.1))])
    schedule = StickSchedule([(1.0, Stick(0.1)), (2.0, Stick())])
    at = {0.0: 0.0, 0.999: 0.0, 1.0: 0.1, 1.9: 0.1, 2.0: 0.0, 9.0: 0.0}
    assert {t: schedule.at(t).forward for t in at} == at
    with pytest.raises(InputError, match="stick"):
        steered_of().stick = 0.3
    with pytest.raises(InputError, match="who walks"):
        SteeredWalk(PLANNER)
