"""What every rival keeps of the protocol: bounds, memory, taking over, holding, new contacts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from equipoise.control import ControlStatus, Measurement
from equipoise.errors import InputError, ShapeError
from rival_ticks import DT, LAWS, random_tick, rival_at, soles_only, stand

EVERY = pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)


def run(rival, robot, rng, q, first=0, count=4):
    return [rival.step((first + k) * DT, *random_tick(robot, rng, q)) for k in range(count)]


@EVERY
def test_a_state_continues_to_the_bit(hrp2, rng, law):
    q = hrp2.q_half_sitting
    one = rival_at(hrp2, q, law, k_i=3.0)
    run(one, hrp2, rng, q)
    state = one.state()
    other = rival_at(hrp2, q, law, stack=soles_only(hrp2, q), k_i=3.0)
    other.restore(state)
    assert [c.name for c in other.contacts.contacts] == [c.name for c in one.contacts.contacts]
    for a, b in zip(
        run(one, hrp2, np.random.default_rng(1), q, 4),
        run(other, hrp2, np.random.default_rng(1), q, 4),
        strict=True,
    ):
        np.testing.assert_array_equal(a.tau, b.tau)
    assert all(not np.shares_memory(v, one.memory[n]) for n, v in state.items() if n != "contacts")


@EVERY
def test_the_motors_get_what_is_left_of_the_base_and_no_more_than_they_can(hrp2, rng, law):
    """`u - J_S^T F` has no base rows; torques keep their limits however wild the tick."""
    q = hrp2.q_half_sitting
    rival = rival_at(hrp2, q, law)
    measured, reference = random_tick(hrp2, rng, q, near=1e-5, speed=1e-3)
    command = rival.step(0.0, measured, reference)
    kin = hrp2.at(measured.q, measured.v)
    J_S = rival.contacts.jacobian(kin)[rival.contacts.supporting_rows]
    left = command.u - J_S.T @ command.base_reaction
    assert np.abs(left[:6]).max() < 1e-3 * np.abs(command.u[:6]).max()
    wild = rival.step(DT, *random_tick(hrp2, rng, q, near=0.3))
    assert (np.abs(wild.tau) <= hrp2.tau_max).all()
    assert np.isfinite(wild.tau).all()


@EVERY
def test_it_begins_from_a_measured_torque_and_forgets_it(hrp2, rng, law):
    q = hrp2.q_half_sitting
    rival, other = rival_at(hrp2, q, law), rival_at(hrp2, q, law)
    tick = random_tick(hrp2, rng, q, near=1e-5)
    start = 0.1 * hrp2.tau_max
    rival.take_over(start)
    np.testing.assert_allclose(rival.step(0.0, *tick).tau, start, atol=1e-9)
    other.step(0.0, *tick)
    late = [one.step(0.3, *tick).tau for one in (rival, other)]
    first = rival_at(hrp2, q, law).step(0.0, *tick).tau
    np.testing.assert_allclose(late[0] - late[1], (start - first) * np.exp(-1.0), atol=1e-6)


@EVERY
def test_a_hole_in_the_measurement_holds_the_torque(hrp2, rng, law):
    q = hrp2.q_half_sitting
    rival = rival_at(hrp2, q, law)
    measured, reference = random_tick(hrp2, rng, q)
    before = rival.step(0.0, measured, reference).tau
    memory = rival.state()
    for part in range(3):
        broken = Measurement(*(x.copy() for x in measured))
        broken[part][-1] = np.nan
        command = rival.step(DT, broken, reference)
        assert command.status is ControlStatus.HELD
        np.testing.assert_array_equal(command.tau, before)
    after = rival.state()
    assert all(
        np.array_equal(memory[n], after[n], equal_nan=True) for n in memory if n != "contacts"
    )
    with pytest.raises(ShapeError):
        rival.step(DT, Measurement(measured.q, measured.v, measured.lam[:-1]), reference)
    with pytest.raises(InputError, match="push"):
        rival.step(DT, measured, reference._replace(lam_ref=np.array([-1.0])))


@EVERY
def test_the_torque_does_not_jump_when_contacts_change(hrp2, rng, law):
    q = hrp2.q_half_sitting
    rival = rival_at(hrp2, q, law)
    measured, reference = random_tick(hrp2, rng, q, near=1e-5, speed=1e-3)
    before = rival.step(0.0, measured, reference).tau
    rival.switch(soles_only(hrp2, q))
    measured = measured._replace(lam=measured.lam[:12])
    after = rival.step(DT, measured, reference._replace(lam_ref=np.zeros(0))).tau
    np.testing.assert_allclose(after, before, atol=1e-9)


@EVERY
@pytest.mark.parametrize("dt", [1e-3, 2e-3])
def test_it_stands(hrp2, law, dt):
    """At rest on rigid contacts with its own model, from the first tick on."""
    q = hrp2.q_half_sitting
    rival = rival_at(hrp2, q, law, stack=soles_only(hrp2, q), dt=dt)
    assert stand(hrp2, rival, dt) < 1e-4


@pytest.mark.parametrize("kind", LAWS)
def test_a_wrong_model_costs_accuracy_and_an_integral_finds_it(hrp2, kind):
    q = hrp2.q_half_sitting
    wrong = replace(hrp2.scaled(1.1))
    stack = soles_only(hrp2, q)
    off = stand(hrp2, rival_at(wrong, q, LAWS[kind], stack=stack), DT, 0.8)
    mended = stand(hrp2, rival_at(wrong, q, LAWS[kind], stack=stack, k_i=10.0), DT, 0.8)
    assert 1e-4 < off < 1e-2
    assert mended < 0.3 * off


def test_gains_that_overshoot_a_period_are_refused(hrp2):
    q = hrp2.q_half_sitting
    with pytest.raises(InputError, match="kappa"):
        rival_at(hrp2, q, LAWS["idqp"], dt=5e-3, kappa=300.0)
    with pytest.raises(InputError, match="alpha"):
        rival_at(hrp2, q, LAWS["idqp"], alpha=0.0)
