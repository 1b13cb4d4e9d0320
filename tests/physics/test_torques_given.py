"""What is no torque is refused by both engines before anything moves."""

from __future__ import annotations

import numpy as np
import pytest

from equipoise.contacts import ContactStack
from equipoise.errors import InputError
from equipoise.physics import DivergedError, RigidContactEngine
from helpers import sole_contacts


def engine_of(kind: str, robot, dt=0.001):
    stack = ContactStack(sole_contacts(robot, robot.q_half_sitting))
    if kind == "rigid":
        return RigidContactEngine(robot, stack, robot.q_half_sitting, dt)
    pytest.importorskip("mujoco")
    from equipoise.physics.mujoco import MujocoEngine

    return MujocoEngine(robot, stack, robot.q_half_sitting, dt)


def no_torques(na: int) -> dict[str, object]:
    spoilt = {f"{x}": np.where(np.arange(na) == 3, x, 0.0) for x in (np.nan, np.inf, -np.inf)}
    return {
        **spoilt,
        "short": np.zeros(na - 1),
        "long": np.zeros(na + 1),
        "row": np.zeros((1, na)),
        "column": np.zeros((na, 1)),
        "none": None,
        "words": ["a"] * na,
        "complex": np.zeros(na, dtype=complex),
        "objects": np.zeros(na, dtype=object),
        "a number": 0.0,
        "nothing": np.zeros(0),
    }


@pytest.mark.parametrize("kind", ["rigid", "mujoco"])
def test_a_refused_torque_moves_nothing(hrp2, kind):
    engine = engine_of(kind, hrp2)
    engine.step(engine.stand())
    before = engine.state
    for tau in no_torques(hrp2.na).values():
        with pytest.raises(InputError):
            engine.step(tau)
        after = engine.state
        assert after.t == before.t
        assert np.array_equal(after.q, before.q)
        assert np.array_equal(after.v, before.v)
    assert engine.step([0.0] * hrp2.na).t == pytest.approx(0.002)


@pytest.mark.parametrize("kind", ["rigid", "mujoco"])
@pytest.mark.parametrize("dt", [0.0, -1e-3, np.nan, np.inf, "a", None, True])
def test_a_period_that_is_none_is_refused(hrp2, kind, dt):
    with pytest.raises(InputError, match="period"):
        engine_of(kind, hrp2, dt)


@pytest.mark.parametrize("length", [0.0, 0.5, 2.0, 1e-200, np.nan])
def test_a_quaternion_that_is_no_rotation_is_refused(hrp2, length):
    q = hrp2.q_half_sitting.copy()
    q[3:7] = (0.0, 0.0, 0.0, length)
    with pytest.raises(InputError):
        hrp2.at(q)
    q[3:7] = (0.0, 0.0, 0.0, 1.0 + 1e-6)  # what rounding leaves
    hrp2.at(q)


def test_after_a_divergence_the_state_is_the_last_finite_one(hrp2):
    engine = engine_of("rigid", hrp2)
    engine.step(engine.stand())
    before = engine.state
    with pytest.raises(DivergedError):
        engine.step(np.full(hrp2.na, 1e308))
    assert np.array_equal(engine.state.q, before.q)
    assert np.array_equal(engine.state.v, before.v)
