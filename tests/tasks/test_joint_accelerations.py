"""Joints that stop in time: bounds on accelerations, alone, in closed loop, in words."""

from __future__ import annotations

import numpy as np
import pytest

from equipoise.errors import InputError
from equipoise.hqp import make_solver
from equipoise.hqp.explain import explain
from equipoise.motion import MotionGenerator, advise_accelerations
from equipoise.tasks import JointAccelerationsTask, PostureTask, describe_rows
from equipoise.tasks.joint_accelerations import approach_speed

CASES = [
    (5.0, 3.0, 0.001),
    (10.0, 1.0, 0.005),
    (20.0, 40.0, 0.01),
    (50.0, 7.0, 0.02),
    (2.0, 80.0, 0.02),
]


@pytest.mark.parametrize(("rate", "a", "dt"), CASES)
def test_the_approach_never_brakes_harder_and_never_arrives_too_fast(rate, a, dt):
    """Iterated from far away, the room stays and speed drops by at most a dt; both theorems."""
    room, speeds = 25.0 * a / rate**2, []
    for _ in range(int(40.0 / (rate * dt)) + 4000):
        speeds.append(approach_speed(room, rate, a, dt))
        room -= speeds[-1] * dt
        assert room >= 0.0
    braking = -np.diff(speeds) / dt
    assert braking.max() <= a * (1.0 + 1e-10)
    assert braking.min() >= 0.0
    assert room < 1e-2 * a / rate**2


@pytest.mark.parametrize(("rate", "a", "dt"), CASES)
def test_line_and_parabola_meet_with_one_slope(rate, a, dt):
    join = (a / rate) * (1.0 / rate - 0.5 * dt)
    h = 1e-6 * join
    below, at, above = (approach_speed(join + x, rate, a, dt) for x in (-h, 0.0, h))
    assert at == pytest.approx(rate * join)
    assert (above - at) / h == pytest.approx((at - below) / h, rel=1e-4)


def test_without_a_bound_it_is_the_line():
    for room in np.random.default_rng(1).uniform(-1.0, 3.0, 20):
        assert approach_speed(room, 5.0, 1e9, 0.01) == pytest.approx(5.0 * room)


@pytest.mark.parametrize("dt", [0.001, 0.005, 0.02])
def test_bounds_hold_in_closed_loop_against_a_wild_posture(hrp2, dt):
    """Position, speed and acceleration of every joint, while a posture flips between the stops."""
    a = advise_accelerations(hrp2, hrp2.q_half_sitting, share=0.5, rise=0.2).bound
    task = JointAccelerationsTask("accelerations", hrp2, a, dt, rate=10.0)
    ends = [hrp2.q_max + 1.0, hrp2.q_min - 1.0]
    motion = MotionGenerator(
        hrp2, [[task], [PostureTask("wild", hrp2, ends[0], rate=30.0)]],
        make_solver("active_set"), dt, hrp2.q_half_sitting,
    )  # fmt: skip
    before, fastest = np.zeros(hrp2.na), np.zeros(hrp2.na)
    numbers = motion.workspace.parts["tasks"].numbers[-hrp2.na :]
    for k in range(round(6.0 / dt)):
        numbers[:] = ends[int(k * dt / 1.3) % 2]
        step = motion.step(k * dt)
        v = step.v_ref[6:]
        assert np.all(np.abs(v - before) <= a * dt * (1.0 + 1e-9) + 1e-12)
        assert np.all(np.abs(v) <= hrp2.v_max)
        q = step.q_ref[7:]
        assert np.all((q >= hrp2.q_min) & (q <= hrp2.q_max))
        before, fastest = v, np.maximum(fastest, np.abs(v - before) / dt)
    assert np.count_nonzero(fastest > 0.99 * a) > 0.9 * hrp2.na  # it is they that held


def test_the_kernel_in_the_tick_writes_what_the_task_alone_does(hrp2):
    a = np.linspace(1.0, 9.0, hrp2.na)
    task = JointAccelerationsTask("accelerations", hrp2, a, 0.01)
    wild = PostureTask("wild", hrp2, hrp2.q_max, rate=30.0)
    motion = MotionGenerator(
        hrp2, [[task], [wild]], make_solver("active_set"), 0.01, hrp2.q_half_sitting
    )
    v = np.zeros(hrp2.nv)
    for k in range(40):
        step = motion.step(0.01 * k)
        alone = task.rows(hrp2.at(step.q_ref, v), 0.01 * k)
        rows = step.hierarchy.blocks[0].rows
        np.testing.assert_allclose(step.hierarchy.lower[rows], alone.lower, atol=1e-14)
        np.testing.assert_allclose(step.hierarchy.upper[rows], alone.upper, atol=1e-14)
        np.testing.assert_array_equal(step.hierarchy.A[rows], alone.A)
        assert np.all(alone.lower <= alone.upper)
        v = step.v_ref.copy()


def test_lower_never_exceeds_upper_whatever_the_state(hrp2):
    rng = np.random.default_rng(3)
    task = JointAccelerationsTask("a", hrp2, rng.uniform(0.1, 50.0, hrp2.na), 0.01)
    for _ in range(200):
        q, v = hrp2.q_half_sitting.copy(), rng.normal(size=hrp2.nv) * 20.0
        q[7:] = rng.uniform(hrp2.q_min - 1.0, hrp2.q_max + 1.0)
        rows = task.rows(hrp2.at(q, v), 0.0)
        assert np.all(rows.lower <= rows.upper)
        assert np.all(rows.upper - rows.lower <= 2.0 * task.acceleration * 0.01 * (1.0 + 1e-9))


def test_it_explains_in_words_what_bounds_a_joint(hrp2):
    dt, a = 0.01, np.full(hrp2.na, 2.0)
    task = JointAccelerationsTask("accelerations", hrp2, a, dt)
    wild = PostureTask("wild", hrp2, hrp2.q_max, rate=20.0)
    motion = MotionGenerator(
        hrp2, [[task], [wild]], make_solver("active_set"), dt, hrp2.q_half_sitting
    )
    said = set()
    for k in range(400):
        step = motion.step(k * dt)
        if k in (0, 60, 399):
            words = describe_rows([task, wild], step.hierarchy)
            said.add(str(explain(step.hierarchy, step.solution.v, words)))
    text = " ".join(said)
    assert "the acceleration limit of" in text
    assert "needs to stop before its upper limit" in text


def test_a_task_made_for_another_period_is_refused(hrp2):
    task = JointAccelerationsTask("accelerations", hrp2, np.ones(hrp2.na), 0.01)
    with pytest.raises(InputError, match="made for another period"):
        MotionGenerator(hrp2, [[task]], make_solver("active_set"), 0.02, hrp2.q_half_sitting)


@pytest.mark.parametrize("a", [0.0, -1.0, np.nan, np.inf])
def test_bounds_that_are_none_are_refused(hrp2, a):
    bounds = np.ones(hrp2.na)
    bounds[3] = a
    with pytest.raises(InputError, match="bounds of task 'a'"):
        JointAccelerationsTask("a", hrp2, bounds, 0.01)


def test_the_advice_is_what_torque_and_rise_time_allow(hrp2):
    advice = advise_accelerations(hrp2, hrp2.q_half_sitting, share=0.4, rise=0.1)
    assert np.all(advice.bound <= 0.4 * hrp2.v_max / 0.1 + 1e-12)
    assert np.all(advice.bound <= 0.4 * hrp2.tau_max / advice.inertia)
    ankle = hrp2.joint_index("LLEG_JOINT4")
    wrist = hrp2.joint_index("LARM_JOINT6")
    assert advice.by_torque[ankle] < 20.0  # it moves the whole robot
    assert advice.by_torque[wrist] > 1000.0
    assert "rad/s^2" in advice.sentences()[0]
    halved = advise_accelerations(hrp2, hrp2.q_half_sitting, share=0.2, rise=0.1)
    np.testing.assert_allclose(halved.bound, 0.5 * advice.bound)
    for wrong in ({"share": 0.0}, {"rise": -1.0}, {"speed": 0.0}):
        with pytest.raises(InputError):
            advise_accelerations(hrp2, hrp2.q_half_sitting, **wrong)
