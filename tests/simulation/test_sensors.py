"""Sensors: their statistics, filter and delay are what was asked for, and a seed repeats them."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from equipoise.contacts import ContactStack
from equipoise.errors import InputError, NameNotFoundError
from equipoise.physics import PhysicsState
from equipoise.simulation.sensors import SensorModel, SensorModels, SensorSuite, Silence
from helpers import random_state, sole_contacts

DT = 1e-3


@pytest.fixture
def stack(hrp2):
    return ContactStack(sole_contacts(hrp2, hrp2.q_half_sitting))


def states(robot, stack, rng, n, moving=True):
    """Yield n states along a straight way in the tangent."""
    q, v = random_state(robot, rng, spread=0.1)
    for k in range(n):
        here = pin.integrate(robot.model, q, v * DT * k) if moving else q
        yield PhysicsState(k * DT, here, v, np.arange(stack.size) + float(k * moving), 0.0)


def test_perfect_sensors_show_the_state(hrp2, stack, rng):
    suite = SensorSuite(hrp2, stack, SensorModels(), DT, seed=0)
    for state in states(hrp2, stack, rng, 5):
        reading = suite.read(state)
        assert np.array_equal(reading.q, state.q)
        assert np.array_equal(reading.v, state.v)
        assert np.array_equal(reading.lam, state.lam)


def test_noise_has_the_wanted_spread_and_a_seed_repeats_it(hrp2, stack, rng):
    models = SensorModels(
        joint_position=SensorModel(noise=1e-3),
        base_angle=SensorModel(noise=2e-3),
        force=SensorModel(noise=0.7),
    )
    suites = [SensorSuite(hrp2, stack, models, DT, seed=4) for _ in range(2)]
    joints, angles, forces, moments = [], [], [], []
    for state in states(hrp2, stack, rng, 2000, moving=False):
        first, second = (suite.read(state) for suite in suites)
        assert np.array_equal(first.q, second.q)
        assert abs(np.linalg.norm(first.q[3:7]) - 1.0) < 1e-12
        error = pin.difference(hrp2.model, state.q, first.q)
        joints.append(error[6:])
        angles.append(error[3:6])
        forces.append((first.lam - state.lam)[[0, 1, 2, 6, 7, 8]])
        moments.append((first.lam - state.lam)[3:6])
    assert np.std(joints) == pytest.approx(1e-3, rel=0.05)
    assert np.std(angles) == pytest.approx(2e-3, rel=0.05)
    assert np.std(forces) == pytest.approx(0.7, rel=0.05)
    assert not np.any(moments)


def test_a_bias_is_constant_and_differs_by_component(hrp2, stack, rng):
    models = SensorModels(joint_velocity=SensorModel(bias=0.1))
    suite = SensorSuite(hrp2, stack, models, DT, seed=1)
    errors = [suite.read(s).v - s.v for s in states(hrp2, stack, rng, 3)]
    assert np.allclose(errors[0], errors[2], atol=1e-15)
    assert not np.any(errors[0][:6])
    assert len(np.unique(errors[0][6:])) == hrp2.na


def test_a_filter_answers_a_step_like_a_first_order_lag(hrp2, stack):
    tau = 0.02
    models = SensorModels(force=SensorModel(filter_time=tau))
    suite = SensorSuite(hrp2, stack, models, DT, seed=1)
    q, v = hrp2.q_half_sitting, np.zeros(hrp2.nv)
    for k in range(61):
        lam = np.full(stack.size, 0.0 if k == 0 else 1.0)
        reading = suite.read(PhysicsState(k * DT, q, v, lam, 0.0))
        assert reading.lam[0] == pytest.approx(1.0 - np.exp(-k * DT / tau), abs=1e-12)


def test_a_delay_shows_the_past(hrp2, stack, rng):
    models = SensorModels(joint_position=SensorModel(delay=0.0025))
    suite = SensorSuite(hrp2, stack, models, DT, seed=1)
    past = []
    for k, state in enumerate(states(hrp2, stack, rng, 12)):
        past.append(state)
        reading = suite.read(state)
        assert np.allclose(reading.q[7:], past[max(k - 3, 0)].q[7:], atol=1e-12)
        assert np.allclose(reading.q[:3], state.q[:3], atol=1e-12)


@pytest.mark.parametrize("kind", ["nan", "frozen"])
def test_a_lost_sensor_is_silent_only_in_its_window(hrp2, stack, rng, kind):
    joint = hrp2.joint_names[3]
    silences = (Silence(joint, 0.003, 0.006, kind), Silence("left_sole", 0.002, reading=kind))
    suite = SensorSuite(hrp2, stack, SensorModels(silences=silences), DT, seed=1)
    before = None
    for k, state in enumerate(states(hrp2, stack, rng, 9)):
        reading = suite.read(state)
        wrong_q = np.flatnonzero(reading.q != state.q)
        wrong_lam = np.flatnonzero(reading.lam != state.lam)
        assert list(wrong_q) == ([10] if 3 <= k < 6 else [])
        assert list(wrong_lam) == (list(range(6)) if k >= 2 else [])
        if kind == "frozen" and k >= 3:
            assert np.array_equal(reading.lam[:6], before.lam[:6])
        elif k >= 2:
            assert np.isnan(reading.lam[:6]).all() == (kind == "nan")
        before = reading


def test_a_wrong_sensor_is_named_with_its_neighbours(hrp2, stack):
    models = SensorModels(silences=(Silence("left_sol", 0.0),))
    with pytest.raises(NameNotFoundError, match="Did you mean 'left_sole'"):
        SensorSuite(hrp2, stack, models, DT, seed=1)


def test_a_negative_noise_is_refused():
    with pytest.raises(InputError, match="noise"):
        SensorModel(noise=-1.0)
