"""Changing contacts while running: the torque does not jump, and the manifolds start anew."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from equipoise.contacts import ContactSchedule, ContactStack
from equipoise.control import (
    ControlGains,
    Measurement,
    PassivityController,
    Reference,
    SignFunction,
    advise_gains,
)
from helpers import full_stack, random_state, sole_contacts

DT = 1e-3


def loaded_controller(robot, q):
    """Return a controller whose integral has wound up to something, and its last inputs."""
    soles = ContactStack(sole_contacts(robot, q))
    K_d = advise_gains(robot, soles, q, DT, alpha=20.0, kappa=300.0).K_d
    gains = ControlGains(K_d=K_d, sgn_p=SignFunction("saturation", 0.05))
    controller = PassivityController(robot, soles, gains, DT)
    off = pin.integrate(robot.model, q, 0.002 * np.sin(np.arange(robot.nv)))
    still, lam = np.zeros(robot.nv), np.zeros(12)
    controller.step(0.0, Measurement(q, still, lam), Reference(q, still, np.zeros(0)))
    for k in range(1, 100):
        controller.step(k * DT, Measurement(off, still, lam), Reference(q, still, np.zeros(0)))
    return controller, off, still


def test_taking_up_a_contact_makes_no_jump(hrp2, rng):
    q, _ = random_state(hrp2, rng, 0.05)
    controller, off, still = loaded_controller(hrp2, q)
    before = controller.tau.copy()
    more = full_stack(hrp2, q)
    controller.switch(more)
    measured = Measurement(off, still, np.zeros(18))
    command = controller.step(0.1, measured, Reference(q, still, np.zeros(1)))
    assert np.abs(command.tau - before).max() < 1e-9 * np.abs(before).max()
    assert np.abs(controller.posture.s_qp).max() == 0.0
    assert np.abs(controller.force.s_qF).max() == 0.0
    controller.handover[:] = 0.0
    bare = controller.step(0.1, measured, Reference(q, still, np.zeros(1)))
    assert np.abs(bare.tau - before).max() > 1e-3 * np.abs(before).max()


def test_the_handed_over_part_fades(hrp2, rng):
    q, _ = random_state(hrp2, rng, 0.05)
    controller, off, still = loaded_controller(hrp2, q)
    controller.switch(full_stack(hrp2, q))
    target = Reference(q, still, np.zeros(1))
    measured = Measurement(off, still, np.zeros(18))
    controller.step(0.1, measured, target)
    offset = controller.handover.copy()
    assert np.abs(offset).max() > 0.0
    share = np.exp(-0.6 / controller.gains.handover)
    u = controller.step(0.7, measured, target).u
    controller.handover[:] = 0.0
    s_free = controller.step(0.7, measured, target).u
    faded = u - s_free
    assert np.linalg.norm(faded) < 2.0 * share * np.linalg.norm(offset) + 1.0


def test_taking_over_begins_with_the_measured_torque(hrp2, rng):
    q = hrp2.q_half_sitting
    soles = ContactStack(sole_contacts(hrp2, q))
    controller = PassivityController(hrp2, soles, ControlGains(K_d=10.0), DT)
    tau = rng.normal(size=hrp2.na)
    controller.take_over(tau)
    lam = np.zeros(12)
    still = np.zeros(hrp2.nv)
    command = controller.step(0.0, Measurement(q, still, lam), Reference(q, still, np.zeros(0)))
    assert np.allclose(command.tau, tau, atol=1e-9)


def test_a_schedule_gives_the_stack_of_the_time(hrp2):
    contacts = full_stack(hrp2, hrp2.q_half_sitting).contacts
    schedule = ContactSchedule(contacts, {"grasp": (1.0, 2.0)})
    names = [tuple(schedule.at(t).rows) for t in (0.0, 1.0, 1.999, 2.0)]
    both, all_three = ("left_sole", "right_sole"), ("left_sole", "right_sole", "grasp")
    assert names == [both, all_three, all_three, both]
    assert schedule.at(1.2) is schedule.at(1.7)
