"""Faults on demand: delays, late ticks, weak motors, pushes; and a soak under all of them."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from equipoise.contacts import ContactStack
from equipoise.control import (
    ControlGains,
    Measurement,
    Mode,
    PassivityController,
    Reference,
    Supervisor,
)
from equipoise.errors import InputError
from equipoise.scenarios import read_scenario
from equipoise.simulation.faults import DelayLine, ExternalForce, FaultInjector, Faults
from helpers import kinematics, random_state, sole_contacts

DT = 1e-3


def test_a_delay_line_gives_back_the_past():
    line = DelayLine(0.0021, DT)
    assert [line.pass_on(k) for k in range(6)] == [0, 0, 0, 0, 1, 2]
    assert DelayLine(0.0, DT).pass_on(7) == 7


def test_pushes_act_in_their_window_with_their_power(hrp2, rng):
    frame_id = hrp2.frame_id("CHEST_LINK1")
    push = ExternalForce(frame_id, (30.0, -5.0, 2.0), 1.0, 0.2)
    faults = FaultInjector(hrp2, Faults(pushes=(push,)), DT, seed=0)
    q, v = random_state(hrp2, rng)
    speed = kinematics(hrp2, q, v).twist(frame_id)[:3]
    for t, acts in ((0.999, False), (1.0, True), (1.199, True), (1.2, False)):
        power = faults.external(t, q, v) @ v
        assert power == pytest.approx(np.dot(push.force, speed) if acts else 0.0, abs=1e-9)


def test_weak_motors_and_late_commands(hrp2):
    faults = FaultInjector(hrp2, Faults(command_delay=0.002, torque_share=0.4), DT, seed=0)
    strong = 2.0 * hrp2.tau_max
    given = [faults.torque(k * strong) for k in range(4)]
    assert not np.any(given[2])
    assert np.allclose(given[3], 0.4 * hrp2.tau_max)


def test_missed_ticks_come_as_often_as_asked_and_never_twice(hrp2):
    faults = FaultInjector(hrp2, Faults(missed_ticks=0.2), DT, seed=3)
    missed = np.array([faults.tick_is_missed() for _ in range(20000)])
    assert not (missed[1:] & missed[:-1]).any()
    # A tick may only be missed after one that was not: p / (1 + p) in the long run.
    assert missed.mean() == pytest.approx(0.2 / 1.2, abs=0.01)


@pytest.mark.parametrize(
    "wrong", [{"missed_ticks": 1.0}, {"torque_share": 1.5}, {"command_delay": -1.0}]
)
def test_impossible_faults_are_refused(wrong):
    with pytest.raises(InputError, match=next(iter(wrong))):
        Faults(**wrong)


def make_supervisor(hrp2):
    stack = ContactStack(sole_contacts(hrp2, hrp2.q_half_sitting))
    return Supervisor(
        PassivityController(hrp2, stack, ControlGains(K_d=50.0), DT, filter_time=0.02)
    )


def calm(hrp2, supervisor):
    q = hrp2.q_half_sitting
    size = supervisor.controller.contacts.size
    measured = Measurement(q.copy(), np.zeros(hrp2.nv), np.zeros(size))
    return measured, Reference(q.copy(), np.zeros(hrp2.nv), np.zeros(0))


def test_a_lost_force_is_bridged_and_named(hrp2):
    supervisor = make_supervisor(hrp2)
    measured, target = calm(hrp2, supervisor)
    supervisor.step(0.0, measured, target)
    deaf = Measurement(measured.q, measured.v, np.full_like(measured.lam, np.nan))
    for k in range(1, 200):
        command = supervisor.step(k * DT, deaf, target)
    assert np.isfinite(command.tau).all()
    assert supervisor.mode is Mode.DEGRADED
    assert "the force of left_sole" in supervisor.changes[0].cause
    supervisor.step(0.2, measured, target)
    assert supervisor.mode is Mode.RUN


def test_a_lost_joint_is_bridged_shortly_then_the_posture_is_held(hrp2):
    supervisor = make_supervisor(hrp2)
    measured, target = calm(hrp2, supervisor)
    supervisor.step(0.0, measured, target)
    q = measured.q.copy()
    q[10] = np.nan
    modes = {}
    for k in range(1, 200):
        supervisor.step(k * DT, Measurement(q, measured.v, measured.lam), target)
        modes.setdefault(supervisor.mode, k * DT)
    assert list(modes) == [Mode.DEGRADED, Mode.SAFE]
    assert 0.02 <= modes[Mode.SAFE] <= 0.025
    assert hrp2.joint_names[3] in supervisor.changes[0].cause


def test_where_no_joint_is_measured_the_weight_is_let_down_and_the_torque_stops(hrp2):
    supervisor = make_supervisor(hrp2)
    measured, target = calm(hrp2, supervisor)
    carried = supervisor.step(0.0, measured, target).tau
    q = np.full(hrp2.nq, np.nan)
    v = np.full(hrp2.nv, 0.3)
    modes = {}
    for k in range(1, 2600):
        command = supervisor.step(k * DT, Measurement(q, v, measured.lam), target)
        modes.setdefault(supervisor.mode, k * DT)
        if supervisor.mode is Mode.SAFE:
            assert (command.tau - carried) @ v[6:] <= 1e-9  # beyond the weight it brakes
        if k == 2400:
            assert supervisor.mode is Mode.SAFE  # it moves: it is braked
            v = np.full(hrp2.nv, np.nan)
    assert list(modes) == [Mode.DEGRADED, Mode.SAFE, Mode.STOPPED]
    assert not np.any(command.tau)


def test_a_fallen_robot_is_let_go(hrp2):
    supervisor = make_supervisor(hrp2)
    measured, target = calm(hrp2, supervisor)
    q = measured.q.copy()
    q[3:7] = [np.sin(0.6), 0.0, 0.0, np.cos(0.6)]
    supervisor.step(0.0, Measurement(q, measured.v, measured.lam), target)
    assert supervisor.mode is Mode.SAFE
    assert "base_roll" in supervisor.changes[0].cause


def test_whatever_is_measured_the_torque_is_finite_and_allowed(hrp2, rng):
    """Noise of absurd size, silence, infinities, in any mixture: never a raise."""
    supervisor = make_supervisor(hrp2)
    calm_one, target = calm(hrp2, supervisor)
    for k in range(3000):
        if k % 300 == 0:
            supervisor = make_supervisor(hrp2)
        scale = 10.0 ** rng.uniform(-4, 6) if k % 2 else 1e-3
        parts = []
        for part in (calm_one.q, calm_one.v, calm_one.lam):
            noisy = part + scale * rng.normal(size=part.size)
            holes = rng.random(part.size) < (0.01 if k % 3 else 0.0)
            noisy[holes] = rng.choice([np.nan, np.inf, -np.inf, 1e300], size=holes.sum())
            parts.append(noisy)
        command = supervisor.step(k * DT, Measurement(*parts), target)
        assert np.isfinite(command.tau).all()
        assert (np.abs(command.tau) <= hrp2.tau_max).all()


def test_a_shifted_centre_of_mass_is_off_by_what_was_asked():
    """At half-sitting the plant's centre of mass lies off by the shift, its mass is the same."""
    from equipoise.simulation.build.plant import plant_robot
    from equipoise.simulation.build.setup import build_setup

    shift = [0.03, -0.01, 0.02]
    scenario = read_scenario("press", [f"disturbances.com_shift={shift}"])
    setup = build_setup(scenario)
    plant, q = plant_robot(scenario, setup), setup.robot.q_half_sitting
    there, here = (
        pin.centerOfMass(one.model, one.model.createData(), q) for one in (plant, setup.robot)
    )
    np.testing.assert_allclose(there - here, shift, atol=1e-12)
    assert plant.mass == setup.robot.mass
