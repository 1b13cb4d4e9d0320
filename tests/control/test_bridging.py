"""Holes of a measured state: what feet, differences and the reference say of what is lost."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from equipoise.contacts import ContactStack
from equipoise.control import Measurement
from equipoise.control.bridging import Bridge
from equipoise.control.found_by_contacts import FoundByContacts, found_by_contacts, loads_of
from equipoise.control.passivity.gain_advice import handed_over, inertia_matrix, null_space
from equipoise.control.passivity.nearest import NearestVelocity
from equipoise.kinematics import KinematicsEvaluator
from equipoise.robots import get_robot
from helpers import sole_contacts

DT = 1e-3
ROBOTS = ("hrp2", "talos", "g1", "romeo")


def standing(name):
    robot = get_robot(name)
    return robot, ContactStack(sole_contacts(robot, robot.q_half_sitting))


def moving(robot, stack, v, steps):
    """Return q after so many ticks of a velocity that keeps the soles, and that velocity."""
    q = robot.q_half_sitting.copy()
    for _ in range(steps):
        at = stack.at(robot.at(q))
        q = pin.integrate(robot.model, q, DT * at.project(v) - at.lift(stack.residual(robot.at(q))))
    return q, stack.at(robot.at(q)).project(v)


def test_a_foot_in_the_air_does_not_move_the_base():
    """The ankle of a foot that bears nothing turns: the base stays. Of the other: it tilts."""
    robot, stack = standing("g1")
    q, kinematics = robot.q_half_sitting, KinematicsEvaluator(robot)
    lost = np.arange(robot.nv) < 6
    ankle = robot.nq_base + robot.joint_index("right_ankle_roll_joint")
    turned, still = q.copy(), np.zeros(robot.nv)
    turned[ankle] += 0.05
    tilts = []
    for share in (0.0, 1.0):
        loads = np.array([1.0 - share, share])
        found = found_by_contacts(robot, stack, q, (turned, still), (lost, loads), kinematics)
        assert found is not None
        tilts.append(np.linalg.norm(pin.difference(robot.model, q, found[0])[3:6]))
    assert tilts[0] < 1e-3
    assert tilts[1] == pytest.approx(0.05, rel=0.02)


@pytest.mark.parametrize("name", ROBOTS)
def test_a_hold_without_a_base_does_not_shake_a_free_foot(name):
    """Rates of M^-1 P M N [T; I], the left foot held, the right one free, the base from the left.

    With both feet counted, or with the projector as printed, they are 40 to 2,000 times as fast.
    """
    robot, stack = standing(name)
    q, base = robot.q_half_sitting, robot.nv_base
    J, M = stack.jacobian(robot.at(q)), inertia_matrix(robot, q)
    M_plant = M + np.diag(np.concatenate((np.zeros(base), np.full(robot.na, 0.05))))
    Z, P = null_space(J[:6]), handed_over(J, base)
    printed = np.eye(robot.nv) - np.linalg.pinv(J) @ J

    def fastest(rows, Q):
        T = -np.linalg.pinv(J[rows, :base]) @ J[rows, base:]
        A = np.zeros((robot.nv, robot.nv))
        A[:, base:] = P @ M @ Q @ np.vstack((T, np.eye(robot.na)))
        loop = np.linalg.solve(Z.T @ M_plant @ Z, Z.T @ A @ Z)
        return np.abs(np.linalg.eigvals(loop)).max()

    nearest = NearestVelocity(J, M).N
    assert fastest(slice(0, 6), nearest) < 1.1
    assert fastest(slice(0, 12), nearest) > 40.0
    assert fastest(slice(0, 6), printed) > 20.0


def test_a_base_that_moves_steadily_is_followed_without_trailing():
    robot, stack = standing("hrp2")
    found = FoundByContacts(robot, DT, 0.025)
    wanted = np.zeros(robot.nv)
    wanted[1] = 0.05
    q, v = moving(robot, stack, wanted, 0)
    last, lost, lam = (q, v), np.arange(robot.nv) < 6, np.zeros(stack.size)
    for _ in range(60):
        q = pin.integrate(robot.model, q, DT * v)
        guess = q.copy()
        guess[:7] = last[0][:7]
        answer = found.follow(stack, last, (guess, np.where(lost, 0.0, v)), lost, lam)
        assert answer is not None
        apart = pin.difference(robot.model, q, answer[0])[:6]
    gone = np.linalg.norm(pin.difference(robot.model, last[0], q)[:3])
    assert np.abs(apart).max() < 0.1 * gone


def test_loads_are_shares_and_alike_where_nothing_is_known():
    _, stack = standing("hrp2")
    lam = np.zeros(stack.size)
    assert loads_of(stack, lam) == pytest.approx([0.5, 0.5])
    lam[2], lam[8] = 300.0, -4.0
    assert loads_of(stack, lam) == pytest.approx([1.0, 0.0])
    lam[2] = np.nan
    assert loads_of(stack, lam) == pytest.approx([0.5, 0.5])


@pytest.mark.parametrize("dt", [0.001, 0.005])
def test_what_is_known_of_a_joint_tells_the_rest(dt):
    """Lost velocities come from positions, lost positions from velocities."""
    robot, stack = standing("hrp2")
    wave, q_0 = 0.3, robot.q_half_sitting
    for lost in ("v", "q"):
        bridge = Bridge(robot, dt, 0.005)
        last = Measurement(q_0.copy(), np.zeros(robot.nv), np.zeros(stack.size))
        for k in range(1, round(0.2 / dt)):
            q, v = q_0.copy(), np.zeros(robot.nv)
            q[7:] += wave * (1.0 - np.cos(2.0 * k * dt))
            v[6:] = 2.0 * wave * np.sin(2.0 * k * dt)
            true = Measurement(q.copy(), v.copy(), last.lam)
            (v if lost == "v" else q)[6 if lost == "v" else 7 :] = np.nan
            holes = Measurement(q, v, last.lam)
            last = bridge.fill(stack, holes, last, (q_0, 0.0 * true.v), ask_contacts=True)
        assert last.v == pytest.approx(true.v, abs=2.0 * wave * 2.0 * (0.005 + dt))
        assert last.q == pytest.approx(true.q, abs=2.0 * wave * dt)


def test_what_nobody_knows_keeps_its_error_to_the_reference():
    """Nobody pulls at a base that is not seen: the law's force on it stays as it was."""
    robot, stack = standing("hrp2")
    q, v = robot.q_half_sitting.copy(), np.zeros(robot.nv)
    v[:6] = 0.02
    last = Measurement(q, v, np.zeros(stack.size))
    blind = Measurement(
        np.r_[np.full(7, np.nan), q[7:]], np.r_[np.full(6, np.nan), v[6:]], last.lam
    )
    bridge, v_ref = Bridge(robot, DT, 0.005), np.zeros(robot.nv)
    q_ref = pin.integrate(robot.model, q, np.r_[0.01, np.zeros(robot.nv - 1)])
    kept = []
    for _ in range(10):
        v_ref = v_ref + 0.01
        q_ref = pin.integrate(robot.model, q_ref, DT * v_ref)
        now = bridge.fill(stack, blind, last, (q_ref, v_ref), ask_contacts=False)
        dq, dv = pin.difference(robot.model, q_ref, now.q), now.v - v_ref
        kept.append(np.concatenate((dq[:6], dv[:6])))
    assert kept[-1] == pytest.approx(kept[0], abs=1e-9)
