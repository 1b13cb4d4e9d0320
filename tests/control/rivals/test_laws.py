"""Each rival's own identity: what its authors derived, checked against an independent answer."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from equipoise.contacts import ContactStack
from equipoise.control import Measurement, Reference
from equipoise.control.rivals.idqp import InverseDynamicsQP
from fixed_arm import small_arm
from rival_ticks import DT, LAWS, random_tick, rival_at, seen_by, soles_only

PROGRAMS = pytest.mark.parametrize("kind", ["idqp", "passive_qp"])


def at_work(robot, rng, kind):
    """Return a rival with its command and tick, at a random state near half-sitting."""
    q = robot.q_half_sitting
    rival = rival_at(robot, q, LAWS[kind])
    command, tick = seen_by(rival, *random_tick(robot, rng, q, near=1e-4, speed=1e-3))
    return rival, command, tick


def constrained(rival, tick, tau):
    """Return accelerations and multipliers of the robot under `tau`, with all contacts rigid."""
    robot, J = rival.robot, tick.rows.J
    M = pin.crba(robot.model, robot.model.createData(), tick.measured.q)
    M = np.triu(M) + np.triu(M, 1).T
    h = pin.rnea(
        robot.model, robot.model.createData(), tick.measured.q, tick.measured.v, np.zeros(robot.nv)
    )
    saddle = np.block([[M, -J.T], [J, np.zeros((len(J), len(J)))]])
    full = np.concatenate((np.zeros(robot.nv_base), tau))
    kept = rival.contact_accelerations(tick)
    found = np.linalg.solve(saddle, np.concatenate((full - h, kept)))
    return found[: robot.nv], found[robot.nv :]


@PROGRAMS
def test_the_program_keeps_the_dynamics_and_the_contacts(hrp2, rng, kind):
    """M a + h = S^T tau + J^T f, and the robot under tau has just these a and f."""
    rival, command, tick = at_work(hrp2, rng, kind)
    found = rival.optimum(tick)
    J = tick.rows.J
    given = np.concatenate((np.zeros(6), command.tau))
    residual = found.M @ found.a + found.h - given - J.T @ found.f
    assert np.abs(residual).max() < 1e-7
    assert np.abs(J @ found.a - rival.contact_accelerations(tick)).max() < 1e-8
    a, f = constrained(rival, tick, command.tau)
    np.testing.assert_allclose(a, found.a, atol=1e-5)
    np.testing.assert_allclose(f, found.f, atol=1e-4)


@PROGRAMS
@pytest.mark.parametrize("pull", [0.002, 0.01, 0.03])
def test_the_program_keeps_its_bounds(hrp2, rng, kind, pull):
    q = hrp2.q_half_sitting
    rival = rival_at(hrp2, q, LAWS[kind])
    measured, reference = random_tick(hrp2, rng, q, near=1e-5)
    away = pin.integrate(hrp2.model, q, np.r_[pull, 0.0, 0.0, np.zeros(hrp2.nv - 3)])
    _, tick = seen_by(rival, measured, reference._replace(q_ref=away))
    found, floor = rival.optimum(tick), rival.floor
    assert found.solved
    assert found.bounded or pull < 0.01
    assert (np.abs(found.tau) <= hrp2.tau_max * (1.0 + 1e-6)).all()
    assert (floor.A @ found.f[rival.contacts.supporting_rows] - floor.b).min() > -1e-5
    assert (found.f[rival.pressing] > -1e-6).all()


def test_where_no_bound_matters_the_program_is_its_closed_form(hrp2, rng):
    """The saddle point of the cost and the equalities, written down without elimination."""
    rival, _, tick = at_work(hrp2, rng, "idqp")
    found = rival.optimum(tick)
    assert not found.bounded
    nv, r, J = hrp2.nv, len(tick.rows.J), tick.rows.J
    metric = rival._metric(found.M)
    W = metric.T @ metric
    np.testing.assert_allclose(W[:nv, :nv], found.M, atol=1e-9)
    goal = np.concatenate((rival.acceleration(tick), tick.forces))
    E = np.vstack((np.hstack((found.M[:6], -J[:, :6].T)), np.hstack((J, np.zeros((r, r))))))
    e = np.concatenate((-found.h[:6], rival.contact_accelerations(tick)))
    saddle = np.block([[W, E.T], [E, np.zeros((len(e), len(e)))]])
    x = np.linalg.solve(saddle, np.concatenate((W @ goal, e)))
    np.testing.assert_allclose(found.a, x[:nv], atol=1e-6)
    np.testing.assert_allclose(found.f, x[nv : nv + r], atol=1e-3)


def test_the_wanted_force_is_the_force(hrp2, rng):
    """With motors enough the program and the projection press as hard as they are told."""
    for kind in ("idqp", "projected_ct"):
        rival, command, tick = at_work(hrp2, rng, kind)
        regulated = rival.contacts.regulated_rows
        _, f = constrained(rival, tick, command.tau)
        np.testing.assert_allclose(f[regulated], tick.forces[regulated], atol=0.02)


def test_the_projected_torque_gives_the_wanted_acceleration(hrp2, rng):
    """J a = b, and a is the wanted one corrected along M^-1 J^T only; no smaller torque does it."""
    rival, command, tick = at_work(hrp2, rng, "projected_ct")
    a, f = constrained(rival, tick, command.tau)
    M = rival.dynamics.inertia(tick.measured.q)
    J = tick.rows.J
    np.testing.assert_allclose(a, rival.consistent(tick, M), atol=1e-6)
    correction = M @ (a - rival.acceleration(tick))
    outside = correction - J.T @ np.linalg.lstsq(J.T, correction, rcond=None)[0]
    assert np.abs(outside).max() < 1e-7 * max(np.abs(correction).max(), 1.0)
    np.testing.assert_allclose(f[rival.others], tick.forces[rival.others], atol=1e-6)
    inner = np.linalg.svd(J[rival.contacts.supporting_rows].T)[0][:, :12]
    hidden = inner @ np.linalg.svd(inner[:6])[2][6:].T  # forces between the feet: no base rows
    assert np.abs(hidden[:6]).max() < 1e-9
    assert np.abs(hidden[6:].T @ command.tau).max() < 1e-7 * np.abs(command.tau).max()


def test_pd_plus_loses_energy_by_its_damping_alone(hrp2, rng):
    """All degrees driven: d/dt (|dv|_M^2 + alpha |dq|_D^2) / 2 = -|dv|_D^2, by a small step."""
    q_ref = hrp2.q_half_sitting
    away = np.r_[np.zeros(6), rng.normal(size=hrp2.na) * 0.05]
    q, v = pin.integrate(hrp2.model, q_ref, away), rng.normal(size=hrp2.nv) * 0.3
    rival = rival_at(hrp2, q_ref, LAWS["pd_plus"], stack=soles_only(hrp2, q_ref))
    still = Reference(q_ref, np.zeros(hrp2.nv), np.zeros(0))
    command, _ = seen_by(rival, Measurement(q, v, np.zeros(12)), still)
    D, alpha, model = rival.memory["damping"], rival.gains.alpha, rival.dynamics
    a = np.linalg.solve(model.inertia(q), command.u - model.bias(q, v))

    def energy(h):
        at = pin.integrate(hrp2.model, q, h * v + 0.5 * h * h * a)
        speed = v + h * a
        dq = pin.difference(hrp2.model, q_ref, at)
        return 0.5 * (speed @ model.inertia(at) @ speed + alpha * dq @ D @ dq)

    h = 1e-5
    power = (energy(h) - energy(-h)) / (2.0 * h)
    assert power == pytest.approx(-v @ D @ v, rel=1e-5)


def test_the_energy_of_the_passive_program_does_not_grow(hrp2, rng):
    """The bound holds where `idqp` breaks it, and changes nothing where `idqp` keeps it."""
    grew = kept = 0
    q = hrp2.q_half_sitting
    for _ in range(20):
        measured, reference = random_tick(hrp2, rng, q, near=5e-4, speed=2e-4)
        passive = rival_at(hrp2, q, LAWS["passive_qp"])
        begun = pin.integrate(hrp2.model, q, np.r_[np.zeros(6), rng.normal(size=hrp2.na) * 0.5])
        passive.memory["damping"] = 100.0 * passive.dynamics.inertia(begun)
        _, tick = seen_by(passive, measured, reference)
        found = passive.optimum(tick)
        row, _, most = passive.more_bounds(tick, found.M, found.h)
        free = InverseDynamicsQP.optimum(rival_at(hrp2, q, InverseDynamicsQP), tick)
        assert row[0] @ np.concatenate((found.a, found.f)) <= most[0] + 1e-6
        if row[0] @ np.concatenate((free.a, free.f)) > most[0]:
            grew += 1
            assert not np.allclose(free.a, found.a)
        else:
            kept += 1
            np.testing.assert_allclose(free.a, found.a, atol=1e-9)
    assert grew
    assert kept


def test_at_rest_gravity_is_carried_by_floor_and_motors(hrp2):
    q = hrp2.q_half_sitting
    for kind in ("gravity_contacts", "hybrid", "admittance", "pd_plus"):
        rival = rival_at(hrp2, q, LAWS[kind], stack=soles_only(hrp2, q))
        still = Reference(q, np.zeros(hrp2.nv), np.zeros(0))
        command, tick = seen_by(rival, Measurement(q, np.zeros(hrp2.nv), np.zeros(12)), still)
        weight = pin.computeGeneralizedGravity(hrp2.model, hrp2.model.createData(), q)
        carried = np.concatenate((np.zeros(6), command.tau)) + tick.rows.J.T @ command.base_reaction
        np.testing.assert_allclose(carried, weight, atol=1e-3)
        assert command.base_reaction[[2, 8]].sum() == pytest.approx(9.81 * hrp2.mass, rel=1e-6)


def test_the_force_direction_of_hybrid_control_knows_no_position(hrp2, rng):
    """Along the regulated row u is gravity and force; elsewhere it is what PD and gravity give."""
    q = hrp2.q_half_sitting
    rival, command, tick = at_work(hrp2, rng, "hybrid")
    D, J_f = rival.memory["damping"], tick.rows.J[rival.contacts.regulated_rows]
    servo = command.u - rival.dynamics.gravity(tick.measured.q) + rival.pressed(tick)
    assert np.abs(J_f @ np.linalg.solve(D, servo)).max() < 1e-8 * np.abs(servo).max()
    plain = rival_at(hrp2, q, LAWS["gravity_contacts"]).wanted(tick)
    along = command.u - plain.u
    outside = along - J_f.T @ np.linalg.lstsq(J_f.T, along, rcond=None)[0]
    assert np.abs(outside).max() < 1e-6 * np.abs(along).max()


def test_an_admittance_gives_way_with_the_force_error(hrp2):
    """After n ticks of a constant error the row has moved by k_f compliance error n dt."""
    q = hrp2.q_half_sitting
    rival = rival_at(hrp2, q, LAWS["admittance"], k_f=4.0)
    lam = np.zeros(18)
    lam[rival.contacts.regulated_rows] = 18.0
    still = Reference(q, np.zeros(hrp2.nv), np.array([15.0]))
    for k in range(5):
        _, tick = seen_by(rival, Measurement(q, np.zeros(hrp2.nv), lam), still, k * DT)
    K = rival.gains.alpha * rival.memory["damping"]
    J_f = tick.rows.J[rival.contacts.regulated_rows]
    compliance = (J_f @ np.linalg.solve(K, J_f.T)).item()
    assert (J_f @ rival.memory["shift"]).item() == pytest.approx(4.0 * compliance * 3.0 * 5 * DT)


@pytest.mark.parametrize("kind", LAWS)
def test_on_a_fixed_base_without_contacts_it_is_the_law_of_an_arm(kind, rng):
    """Inverse dynamics, PD+ or gravity and PD, as in textbooks: nobody carries a base."""
    arm = small_arm()
    q_ref = arm.q_half_sitting
    q, v = q_ref + rng.normal(size=3) * 0.01, rng.normal(size=3) * 0.01
    rival = rival_at(arm, q_ref, LAWS[kind], stack=ContactStack([]))
    still = Reference(q_ref, np.zeros(3), np.zeros(0))
    tau = rival.step(0.0, Measurement(q, v, np.zeros(0)), still).tau
    data, s = arm.model.createData(), v + 20.0 * (q - q_ref)
    if kind in ("idqp", "passive_qp", "projected_ct"):
        expected = pin.rnea(arm.model, data, q, v, -100.0 * s)
    else:
        M = rival.dynamics.inertia(q)
        expected = pin.computeGeneralizedGravity(arm.model, data, q) - 100.0 * M @ s
    np.testing.assert_allclose(tau, expected, atol=1e-9)
