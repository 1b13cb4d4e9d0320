"""Plans of whole walks: balanced at every instant, smooth where they are made anew, mirrored."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from walks import FEET, PLANNER, SETTINGS, STANCE, mirrored

from equipoise.errors import InputError
from equipoise.walking import (
    LEFT,
    RIGHT,
    Footstep,
    Stride,
    SwingShape,
    WalkLimits,
    WalkMode,
    WalkPlanner,
    WalkSettings,
    WalkTiming,
    require_feasible,
    steps_along,
)
from equipoise.walking.feasible import zmp_at, zmp_room
from equipoise.walking.feet import level_pose
from equipoise.walking.footsteps import after

QUICK = replace(SETTINGS, timing=WalkTiming(0.4, 0.15))
SLOW = WalkSettings(0.78, WalkMode.SLOW, WalkTiming(1.0, 0.4, shift=2.0))
STRIDES = [
    Stride(0.2),
    Stride(-0.15),
    Stride(0.0, 0.04),
    Stride(0.1, turn=0.1),
    Stride(0.2, up=0.05),
]


def room_of(planner, stance, steps):
    plan = planner.begin(stance, steps)
    return min(room for _, room, _ in zmp_room(plan, planner.feet, planner.settings))


@pytest.mark.parametrize("settings", [SETTINGS, QUICK, SLOW], ids=["walk", "quick", "slow"])
@pytest.mark.parametrize("stride", STRIDES)
def test_the_zero_moment_point_is_inside_the_soles_at_every_instant(settings, stride):
    planner = WalkPlanner(FEET, settings)
    steps = steps_along(FEET, STANCE, stride, 6)
    assert room_of(planner, STANCE, steps) > 0.005
    require_feasible(planner.begin(STANCE, steps), FEET, settings)


def states_of(plan, times):
    return np.array([[*s.p, *s.v, *s.a, *plan.ground.at(t), *plan.heading.at(t)]
                     for t in times for s in [plan.centre.at(t)]])  # fmt: skip


@pytest.mark.parametrize("settings", [SETTINGS, QUICK, SLOW], ids=["walk", "quick", "slow"])
def test_a_plan_made_anew_at_a_touchdown_goes_on_without_a_jump(settings, rng):
    """Position, velocity and acceleration of the centre; height, heading and their rates."""
    planner = WalkPlanner(FEET, settings)
    steps = steps_along(FEET, STANCE, Stride(0.15, turn=0.05, up=0.02), 6)
    stance, plan = STANCE, planner.begin(STANCE, steps)
    for k, _ in enumerate(steps):
        t = plan.steps[0].land + rng.uniform(-0.05, 0.0)
        T = plan.steps[0].footstep.T_world_sole
        x, y, z = T.translation + rng.uniform(-0.008, 0.008, size=3)
        missed = level_pose(x, y, z, np.arctan2(T.rotation[1, 0], T.rotation[0, 0]) + 0.02)
        stance = after(stance, [Footstep(plan.steps[0].foot, missed)])
        new = planner.go_on(plan, t, stance, steps[k + 1 :], k + 2)
        assert np.abs(states_of(new, [t]) - states_of(plan, [t])).max() < 1e-9
        room = [one for at, one, _ in zmp_room(new, FEET, settings) if at > t + 1e-6]
        assert min(room) > 0.0
        plan = new
    end = plan.centre.at(plan.end)
    assert np.allclose(end.p, FEET.middle(stance).translation[:2], atol=1e-9)


def test_a_plan_made_anew_with_nothing_missed_is_the_plan():
    steps = steps_along(FEET, STANCE, Stride(0.2), 4)
    plan = PLANNER.begin(STANCE, steps)
    t = plan.steps[1].land
    new = PLANNER.go_on(plan, t, after(STANCE, steps[:2]), steps[2:], 3)
    times = np.linspace(t, plan.end, 200)
    assert np.abs(states_of(new, times) - states_of(plan, times)).max() < 1e-9


def test_the_plan_in_the_mirror_is_the_mirrored_plan():
    flip = np.array([1.0, -1.0] * 3 + [1.0, 1.0, -1.0, -1.0])
    swapped = (mirrored(STANCE[RIGHT]), mirrored(STANCE[LEFT]))
    for settings in (SETTINGS, SLOW):
        planner = WalkPlanner(FEET, settings)
        one = planner.begin(STANCE, steps_along(FEET, STANCE, Stride(0.1, 0.03, 0.1), 5))
        other = planner.begin(swapped, steps_along(FEET, swapped, Stride(0.1, -0.03, -0.1), 5))
        times = np.linspace(0.0, one.end, 300)
        assert np.abs(states_of(one, times) - flip * states_of(other, times)).max() < 1e-9


def test_it_starts_and_ends_at_rest_between_the_feet():
    steps = steps_along(FEET, STANCE, Stride(0.2), 4)
    plan = PLANNER.begin(STANCE, steps)
    for t, stance in ((0.0, STANCE), (plan.end, after(STANCE, steps))):
        state = plan.centre.at(t)
        assert np.allclose(state.p, FEET.middle(stance).translation[:2], atol=1e-9)
        assert max(np.abs(state.v).max(), np.abs(state.a).max()) < 1e-8


def test_the_centre_of_mass_makes_room_for_what_swings():
    """What the leg pushes and the pendulum gives way add up to the middle of the sole."""
    heavy = replace(QUICK, leg=0.005)
    plan = WalkPlanner(FEET, heavy).begin(STANCE, steps_along(FEET, STANCE, Stride(0.2), 4))
    pushed = 0.0
    for step in plan.steps:
        stance = plan.stance_before(step)
        middle = FEET.centre(1 - step.foot, stance[1 - step.foot])[:2]
        for t in np.linspace(step.lift + 1e-6, step.land - 1e-6, 50):
            assert np.allclose(zmp_at(plan, heavy, t), middle, atol=1e-9)
            pushed = max(pushed, np.abs(plan.centre.at(t).zmp - middle).max())
    way, share = 0.4, 0.94 * heavy.timing.single
    assert pushed == pytest.approx(0.005 * 10.0 / np.sqrt(3.0) * way / share**2, rel=0.02)
    require_feasible(plan, FEET, heavy)


def refused(steps, settings=SETTINGS, limits=None, stance=STANCE):
    plan = WalkPlanner(FEET, settings).begin(stance, steps)
    with pytest.raises(InputError) as caught:
        require_feasible(plan, FEET, settings, limits)
    return str(caught.value)


def test_what_cannot_be_walked_is_refused_with_the_step_and_the_reason():
    straight = steps_along(FEET, STANCE, Stride(0.2), 4)
    hasty = replace(SLOW, timing=WalkTiming(shift=1.0))
    said = refused(straight, hasty)
    assert "step 1 (right foot)" in said
    assert "outside the soles" in said
    assert "longer shift" in said
    said = refused(straight, limits=WalkLimits(speed=0.8))
    assert "step 2 (left foot) is too fast" in said
    said = refused(straight, limits=WalkLimits(acceleration=3.0))
    assert "too sharp" in said
    across = [straight[0], Footstep(LEFT, level_pose(0.2, -0.06, 0.0, 0.0))]
    said = refused(across)
    assert "step 2 (left foot) meets the other foot" in said
    far = [Footstep(RIGHT, level_pose(0.0, -0.095, 0.0, 0.0))]
    said = refused(far, replace(SETTINGS, timing=WalkTiming(shift=0.05, settle=0.05)))
    assert "before the first step" in said or "step 1" in said


def test_numbers_that_are_no_walk_are_refused():
    for wrong in (lambda: WalkTiming(single=0.0), lambda: SwingShape(height=-0.1),
                  lambda: WalkSettings(0.0), lambda: WalkLimits(margin=-1.0)):  # fmt: skip
        with pytest.raises(InputError):
            wrong()
