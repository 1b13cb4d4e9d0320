"""Supports that change: the map keeps what it promises, by numpy's solution of its equations."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from equipoise.contacts import ContactStack, GraspContact
from equipoise.control import (
    ControlGains,
    Measurement,
    PassivityController,
    Reference,
    SignFunction,
    advise_gains,
)
from equipoise.errors import InputError
from helpers import random_state, sole_contacts

DT = 1e-3


def grasp(robot, kin):
    palms = (palm.frame for palm in robot.palms)
    return GraspContact.holding("grasp", kin, *palms, regulated=("fz",))


def running_law(robot, rng, held, projector, grasped=False, filter_time=0.02):
    """Return a law that has run for some ticks on the first `held` soles, and its last inputs."""
    q, _ = random_state(robot, rng, 0.05)
    soles = sole_contacts(robot, q)
    others = [grasp(robot, robot.at(q))] if grasped else []
    K_d = advise_gains(robot, ContactStack(soles), q, DT, alpha=20.0, kappa=80.0).K_d
    gains = ControlGains(
        K_d=K_d, k_ip=5.0, sgn_p=SignFunction("saturation", 0.05), projector=projector,
        damp_violation=True, integral_max=1e3,
    )  # fmt: skip
    every = ContactStack([*soles, *others])
    law = PassivityController(robot, every, gains, DT, filter_time=filter_time)
    stack = ContactStack([*soles[:held], *others])
    if held < len(soles):
        law.switch(stack)
    k = stack.regulated_rows.size
    for tick in range(5):
        dq = 0.001 * rng.normal(size=robot.nv)
        measured = Measurement(
            pin.integrate(robot.model, q, dq), 0.01 * rng.normal(size=robot.nv),
            5.0 * rng.normal(size=stack.size),
        )  # fmt: skip
        command = law.step(tick * DT, measured, Reference(q, np.zeros(robot.nv), np.full(k, 8.0)))
    return law, every, stack, measured, q, command


@pytest.mark.parametrize("projector", ["euclidean", "damping"])
@pytest.mark.parametrize(("held", "then"), [(2, 1), (1, 2)])
def test_the_torque_is_continuous_whatever_comes_or_goes(hrp2, rng, projector, held, then):
    """Without a filter nothing counts as noise, and the map at a lift takes all of the torque."""
    law, every, _, measured, q, before = running_law(hrp2, rng, held, projector, filter_time=0.0)
    stack = ContactStack(every.contacts[:then])
    law.switch(stack)
    lam = 5.0 * rng.normal(size=stack.size)
    at = Measurement(measured.q, measured.v, lam)
    command = law.step(5 * DT, at, Reference(q, np.zeros(hrp2.nv), np.zeros(0)))
    assert np.abs(command.tau - before.tau).max() < 1e-9 * np.abs(before.tau).max()
    assert np.abs(law.posture.s_qp).max() == 0.0
    assert np.abs(law.handover).max() < 1e-9 * np.abs(law.u).max()
    J = stack.jacobian(hrp2.at(measured.q, measured.v))
    tangent = law.gains.k_ip * law.posture.integral_of_sign
    s_free = command.s - tangent  # what the damping of violating velocities adds
    K = law.gains.damping_matrix(hrp2.nv)
    KKT = np.block([[K, J.T], [J, np.zeros((len(J), len(J)))]])
    tau = np.concatenate((np.zeros(6), before.tau))
    x = np.linalg.solve(KKT, np.concatenate((-tau - K @ s_free, np.zeros(len(J)))))
    assert np.allclose(x[: hrp2.nv], tangent, atol=1e-9 * np.abs(tangent).max())


@pytest.mark.parametrize("projector", ["euclidean", "damping"])
def test_what_a_held_object_feels_does_not_jump(hrp2, rng, projector):
    """The force manifold goes on; what lies along the rows of the hands is handed over."""
    law, every, _, measured, q, before = running_law(hrp2, rng, 2, projector, grasped=True)
    s_F = law.force.s_F.copy()
    one = ContactStack([every.contacts[0], every.contacts[2]])
    law.switch(one)
    lam = np.concatenate((measured.lam[:6], measured.lam[12:]))
    at = Measurement(measured.q, measured.v, lam)
    command = law.step(5 * DT, at, Reference(q, np.zeros(hrp2.nv), np.full(1, 8.0)))
    assert np.abs(command.tau - before.tau).max() < 1e-9 * np.abs(before.tau).max()
    assert np.abs(law.force.s_F - s_F).max() < 10.0 * DT * np.abs(lam).max()
    J = one.jacobian(hrp2.at(measured.q, measured.v))[6:]
    along = np.linalg.lstsq(J.T, law.handover, rcond=None)[0]
    assert np.allclose(J.T @ along, law.handover, atol=1e-8 * np.abs(command.u).max())


def test_the_energy_kept_lets_the_others_bear_what_was_lost(hrp2, rng):
    """The wrench on the base goes on: the foot that stays is asked for what both have given."""
    law, every, _, measured, q, before = running_law(hrp2, rng, 2, "damping")
    J_lost = law.law.J[6:12].copy()
    lost = J_lost.T @ law.law.lam[6:12]
    law.switch(ContactStack(every.contacts[:1]), "energy")
    at = Measurement(measured.q, measured.v, measured.lam[:6])
    still = np.zeros(hrp2.nv)
    command = law.step(5 * DT, at, Reference(q, still, np.zeros(0)))
    J = every.jacobian(hrp2.at(measured.q, measured.v))[:6]
    force = np.concatenate((np.zeros(6), command.tau)) + J.T @ command.base_reaction
    kept = np.concatenate((np.zeros(6), before.tau)) + lost
    left = J.T @ np.linalg.lstsq(J[:, :6].T, (force - kept)[:6], rcond=None)[0]
    assert np.allclose(force - kept, left, atol=1e-8 * np.abs(kept).max())


def test_the_map_goes_on_from_a_state_bit_for_bit(hrp2, rng):
    law, every, _, measured, q, _ = running_law(hrp2, rng, 2, "damping")
    law.switch(ContactStack(every.contacts[1:2]), "energy")
    memory = law.state()
    at = Measurement(measured.q, measured.v, measured.lam[6:])
    target = Reference(q, np.zeros(hrp2.nv), np.zeros(0))
    first = law.step(5 * DT, at, target).tau
    law.restore(memory)
    assert (law.step(5 * DT, at, target).tau == first).all()


def test_what_cannot_be_is_refused(hrp2, rng):
    law, every, *_ = running_law(hrp2, rng, 2, "damping")
    with pytest.raises(InputError, match="energy"):
        law.switch(ContactStack(every.contacts[:1]), "momentum")
    with pytest.raises(InputError, match="no contact supports"):
        law.switch(ContactStack([]))
