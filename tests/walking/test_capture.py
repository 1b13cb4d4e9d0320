"""A step elsewhere: where it has to be, how the foot goes there, and what the plan makes of it."""

from __future__ import annotations

import numpy as np
from walks import DT, FEET, LEFT, PLANNER, RIGHT, SETTINGS, STANCE, walk, walker_of

from equipoise.walking import Stride, steps_along
from equipoise.walking.balance import BalanceFeedback, BalanceSettings
from equipoise.walking.capture import QUICK, StepAside

OMEGA = SETTINGS.omega


def test_where_the_divergent_component_will_be_is_where_the_pendulum_is_then():
    """Against small steps of the pendulum under a zero-moment point that stays."""
    balance = BalanceFeedback(BalanceSettings(), OMEGA, DT)
    balance.p, balance.v = np.array([0.02, -0.01]), np.array([0.1, 0.05])
    balance.zmp = np.array([0.015, 0.003])
    p, v, h, T = balance.p.copy(), balance.v.copy(), 1e-5, 0.3
    for _ in range(round(T / h)):
        v = v + h * OMEGA**2 * (p - balance.zmp)
        p = p + h * v
    assert np.allclose(balance.after(T), p + v / OMEGA, atol=1e-4)


def test_a_foot_goes_aside_smoothly_within_its_reach_and_never_towards_the_other():
    aside, R = StepAside(0.1), np.eye(3)
    for foot, off, wanted in (
        (LEFT, [0.05, 0.04], [0.05, 0.04]),
        (LEFT, [0.05, -0.04], [0.05, 0.0]),
        (RIGHT, [0.05, 0.04], [0.05, 0.0]),
        (RIGHT, [0.3, -0.4], [0.06, -0.08]),
    ):
        aside.lift()
        aside.want(np.array(off), foot, R, 0.4)
        rows = []
        for _ in range(round(0.8 / DT)):
            before = aside.v
            aside.advance(DT)
            rows.append(np.abs(aside.v - before).max() / DT)
        assert np.allclose(aside.p, wanted, atol=1e-3)
        assert max(rows) < 1.05 * QUICK**2 * np.abs(wanted).max()
    here = aside.p.copy()
    aside.want(np.array([0.0, -0.1]), RIGHT, R, 0.01)
    assert np.allclose(aside.wanted, [0.06, -0.08])  # too late
    assert np.allclose(aside.p, here)


def test_a_robot_that_was_pushed_is_caught_by_its_foot_and_walks_on_as_far_aside():
    """Its divergent component runs away over feet that cannot answer, until the step catches it."""
    balance = BalanceFeedback(BalanceSettings(margin=1.0, step=0.2), OMEGA, DT)
    steps = steps_along(FEET, STANCE, Stride(0.2), 6)
    walker = walker_of(PLANNER, steps, balance=balance)
    ground, push = FEET.support(STANCE, (LEFT, RIGHT)), np.array([0.05, 0.0])
    times, centres = [], []

    def each(t):
        if t >= 2.9 and not times:
            times.append(t)
            balance.v = push
        centres.append(walker.targets.centre.row(t)[9:11] + balance.p)
        balance.advance(np.zeros(2), ground)

    walk(walker, each=each)
    [caught] = [one for one in walker.events if one.kind == "aside"]
    off = push / OMEGA * np.exp(OMEGA * (caught.t - times[0]))
    assert np.allclose(caught.off[:2], off, rtol=0.05, atol=1e-6)
    assert not balance.acts
    speeds = np.diff(centres, axis=0) / DT
    jumps = np.abs(np.diff(speeds, axis=0)).max(axis=1)
    assert sorted(jumps)[-2] < 0.02  # but for the push itself
    last = steps[-1]
    there = last.T_world_sole.translation + caught.off
    assert np.allclose(walker.stance[last.foot].translation, there, atol=1e-3)
