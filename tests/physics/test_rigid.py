"""The rigid engine against Pinocchio, conservation laws and its own equation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from equipoise.contacts import ContactStack
from equipoise.errors import InputError
from equipoise.physics import DivergedError, RigidContactEngine, RigidOptions
from helpers import full_stack, kinematics, random_state, sole_contacts


def test_without_contacts_it_is_forward_dynamics(hrp2, rng):
    q, v = random_state(hrp2, rng)
    force = np.concatenate((np.zeros(6), rng.normal(size=hrp2.na) * 20))
    engine = RigidContactEngine(hrp2, ContactStack([]), q, 1e-3, v_start=v)
    a, lam = engine.accelerations(force)
    expected = pin.aba(hrp2.model, hrp2.model.createData(), q, v, force)
    assert lam.size == 0
    assert np.allclose(a, expected, atol=1e-8 * np.abs(expected).max())


def test_solves_the_kkt_system(hrp2, rng):
    """(8): both rows hold, with inertia and bias from Pinocchio."""
    q, v = random_state(hrp2, rng)
    stack = full_stack(hrp2, q)
    force = np.concatenate((np.zeros(6), rng.normal(size=hrp2.na) * 20))
    engine = RigidContactEngine(
        hrp2, stack, q, 1e-3, options=RigidOptions(position_gain=0.0, velocity_gain=0.0), v_start=v
    )
    a, lam = engine.accelerations(force)
    kin = kinematics(hrp2, q, v)
    generalised = force + stack.jacobian(kin).T @ lam
    data = hrp2.model.createData()
    assert np.allclose(pin.rnea(hrp2.model, data, q, v, a), generalised, atol=1e-6)
    residual = stack.jacobian(kin) @ a + stack.drift(kin)
    assert np.abs(residual).max() < 1e-7


def test_agrees_with_pinocchios_constraint_dynamics(hrp2, rng):
    """An independent solver of the same contacts: proximal constrained dynamics."""
    q, v = random_state(hrp2, rng, spread=0.05)
    contacts = sole_contacts(hrp2, q)
    force = np.concatenate((np.zeros(6), rng.normal(size=hrp2.na) * 10))
    stack = ContactStack(contacts)
    v = stack.at(kinematics(hrp2, q)).project(v)  # feet at rest: all notions of drift agree
    engine = RigidContactEngine(
        hrp2, stack, q, 1e-3, options=RigidOptions(position_gain=0.0, velocity_gain=0.0), v_start=v
    )
    a, _ = engine.accelerations(force)
    models = pin.StdVec_RigidConstraintModel()
    for contact in contacts:
        frame = hrp2.model.frames[hrp2.frame_id(contact.frame)]
        models.append(
            pin.RigidConstraintModel(
                pin.ContactType.CONTACT_6D,
                hrp2.model,
                frame.parentJoint,
                frame.placement,
                pin.ReferenceFrame.LOCAL,
            )
        )
    data = hrp2.model.createData()
    datas = pin.StdVec_RigidConstraintData()
    for model in models:
        datas.append(model.createData())
    pin.initConstraintDynamics(hrp2.model, data, models, datas)
    settings = pin.ProximalSettings(1e-12, 1e-10, 50)
    expected = pin.constraintDynamics(hrp2.model, data, q, v, force, models, datas, settings)
    assert np.allclose(a, expected, atol=1e-5 * np.abs(expected).max())


def test_energy_is_kept_without_torque_and_contact(hrp2, rng):
    """Free motion: kinetic and potential energy change only with the integration error."""
    q, v = random_state(hrp2, rng)
    drifts = []
    for dt in (1e-3, 5e-4):
        engine = RigidContactEngine(hrp2, ContactStack([]), q, dt, v_start=v)
        before = _energy(hrp2, q, v)
        for _ in range(round(0.05 / dt)):
            state = engine.step(np.zeros(hrp2.na))
        drifts.append(abs(_energy(hrp2, state.q, state.v) - before))
    assert drifts[1] < 0.6 * drifts[0]
    assert drifts[0] < 0.02 * before


def test_standing_reaction_is_the_weight(hrp2):
    """With the torque of static equilibrium nothing moves and the soles carry the weight."""
    stack = ContactStack(sole_contacts(hrp2, hrp2.q_half_sitting))
    q, still = hrp2.q_half_sitting, np.zeros(hrp2.nv)
    gravity = pin.rnea(hrp2.model, hrp2.model.createData(), q, still, still)
    J = stack.jacobian(kinematics(hrp2, q))
    lam = np.linalg.lstsq(J[:, :6].T, gravity[:6], rcond=None)[0]
    engine = RigidContactEngine(hrp2, stack, q, 1e-3)
    state = engine.step((gravity - J.T @ lam)[6:])
    assert np.abs(state.v).max() < 1e-9
    assert state.lam[2] + state.lam[8] == pytest.approx(9.81 * hrp2.mass, rel=1e-6)


@pytest.mark.parametrize("dt", [1e-3, 5e-4])
def test_drift_stays_small_whatever_the_step(hrp2, rng, dt):
    stack = full_stack(hrp2, hrp2.q_half_sitting)
    engine = RigidContactEngine(
        hrp2, stack, hrp2.q_half_sitting, dt, options=RigidOptions(joint_damping=30.0)
    )
    worst = 0.0
    for k in range(round(1.0 / dt)):
        state = engine.step(30 * np.sin(10 * k * dt + np.arange(hrp2.na)))
        worst = max(worst, state.violation)
    moved = pin.difference(hrp2.model, hrp2.q_half_sitting, state.q)
    assert np.abs(moved).max() > 0.1
    assert worst < 2e-4


def test_a_redundant_contact_changes_nothing_but_who_carries(hrp2, rng):
    q, _ = random_state(hrp2, rng, spread=0.05)
    soles = sole_contacts(hrp2, q)
    twice = ContactStack([*soles, replace(soles[0], name="again")])
    force = np.concatenate((np.zeros(6), rng.normal(size=hrp2.na) * 10))
    a_once, lam_once = RigidContactEngine(hrp2, ContactStack(soles), q, 1e-3).accelerations(force)
    a_twice, lam_twice = RigidContactEngine(hrp2, twice, q, 1e-3).accelerations(force)
    assert np.allclose(a_once, a_twice, atol=1e-6 * np.abs(a_once).max())
    assert np.abs(lam_twice).max() < 10 * np.abs(lam_once).max()
    net = lam_twice[:6] + lam_twice[12:]
    assert np.allclose(net, lam_once[:6], atol=1e-6 * np.abs(lam_once).max())


def test_substeps_are_smaller_steps_under_a_held_torque(hrp2, rng):
    stack = ContactStack(sole_contacts(hrp2, hrp2.q_half_sitting))
    tau = rng.normal(size=hrp2.na) * 5
    held = RigidContactEngine(
        hrp2, stack, hrp2.q_half_sitting, 1e-3, options=RigidOptions(substeps=4)
    )
    fine = RigidContactEngine(hrp2, stack, hrp2.q_half_sitting, 2.5e-4)
    for _ in range(4):
        state = fine.step(tau)
    assert np.allclose(held.step(tau).q, state.q, atol=1e-14)


def test_divergence_is_an_error_that_says_so(hrp2):
    engine = RigidContactEngine(hrp2, ContactStack([]), hrp2.q_half_sitting, 1e-3)
    with pytest.raises(DivergedError, match="diverged at t"):
        engine.step(np.full(hrp2.na, 1e308))


def test_no_substep_is_refused(hrp2):
    with pytest.raises(InputError, match="at least one step"):
        RigidContactEngine(
            hrp2, ContactStack([]), hrp2.q_half_sitting, 1e-3, options=RigidOptions(substeps=0)
        )


def _energy(robot, q, v):
    data = robot.model.createData()
    kinetic = pin.computeKineticEnergy(robot.model, data, q, v)
    return kinetic + pin.computePotentialEnergy(robot.model, data, q)
