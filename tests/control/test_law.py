"""The law (20)-(24): identities, independence of the dynamics, limits, and its promise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from equipoise.contacts import ContactStack, SurfaceContact
from equipoise.contacts.surfaces import Plane
from equipoise.control import (
    ControlGains,
    ControlStatus,
    Measurement,
    PassivityController,
    ReactionBounds,
    Reference,
    SignFunction,
    advise_gains,
)
from equipoise.errors import InputError, ShapeError
from equipoise.physics import RigidContactEngine
from helpers import full_stack, kinematics, random_state, sole_contacts

DT = 1e-3
SMOOTH = SignFunction("saturation", 0.05)


def controller_at(robot, q, **gains) -> PassivityController:
    """Return a controller on soles and grasp anchored at `q`."""
    stack = full_stack(robot, q)
    K_d = advise_gains(robot, stack, q, DT, alpha=20.0, kappa=300.0).K_d
    settings = {"sgn_p": SMOOTH, "sgn_F": SMOOTH, **gains}
    return PassivityController(robot, stack, ControlGains(K_d=K_d, **settings), DT)


def random_tick(robot, rng, q):
    """Return a measurement near `q` and a target there."""
    near = pin.integrate(robot.model, q, rng.normal(size=robot.nv) * 0.01)
    lam = rng.normal(size=18) * 30
    measured = Measurement(near, rng.normal(size=robot.nv) * 0.2, lam)
    return measured, Reference(q, rng.normal(size=robot.nv) * 0.1, np.array([15.0]))


def run_ticks(controller, robot, rng, q, count=5):
    """Feed random ticks; return the last command and measurement."""
    for k in range(count):
        measured, target = random_tick(robot, rng, q)
        command = controller.step(k * DT, measured, target)
    return command, measured


@pytest.mark.parametrize("bounds", [None, ReactionBounds()])
def test_no_motor_is_asked_to_drive_the_base(hrp2, rng, bounds):
    """u - J_r^T F has no base rows, and its joint rows are the torque."""
    q, _ = random_state(hrp2, rng, 0.1)
    controller = controller_at(hrp2, q)
    controller = PassivityController(hrp2, controller.contacts, controller.gains, DT, bounds=bounds)
    command, measured = run_ticks(controller, hrp2, rng, q)
    J_r = controller.contacts.jacobian(kinematics(hrp2, measured.q))[:12]
    applied = command.u - J_r.T @ command.base_reaction
    assert np.abs(applied[:6]).max() < 1e-7 * np.abs(command.u).max()
    if command.status is ControlStatus.RUN:
        assert np.allclose(applied[6:], command.tau, atol=1e-9)


def test_power_identity(hrp2, rng):
    """s^T J_phi^T = -beta s_rF^T: what the force channel does to s."""
    q, _ = random_state(hrp2, rng, 0.1)
    controller = controller_at(hrp2, q, beta=0.3)
    command, measured = run_ticks(controller, hrp2, rng, q)
    J_phi = controller.contacts.jacobian(kinematics(hrp2, measured.q))
    expected = np.zeros(18)
    expected[controller.contacts.regulated_rows] = -0.3 * controller.force.s_rF
    assert np.abs(controller.force.s_rF).max() > 1e-3
    assert np.allclose(J_phi @ command.s, expected, atol=1e-10)


def test_the_law_never_looks_at_masses(hrp2, rng):
    """The same torque, bit for bit, from a robot whose masses and inertias are all ones."""
    q, _ = random_state(hrp2, rng, 0.1)
    nominal = controller_at(hrp2, q)
    blind = PassivityController(
        hrp2.with_unit_inertias(), nominal.contacts, nominal.gains, nominal.dt
    )
    for k in range(20):
        measured, target = random_tick(hrp2, rng, q)
        expected = nominal.step(k * DT, measured, target).tau
        assert np.array_equal(blind.step(k * DT, measured, target).tau, expected)


def test_first_tick_starts_on_the_manifold(hrp2, rng):
    """s_qp(t0) = 0 and s_qF(t0) = 0, so at rest on target only the wanted force is asked for."""
    q, _ = random_state(hrp2, rng, 0.1)
    controller = controller_at(hrp2, q)
    measured, target = random_tick(hrp2, rng, q)
    command = controller.step(0.0, measured, target)
    assert np.abs(controller.posture.s_qp).max() == 0.0
    assert np.abs(controller.force.s_qF).max() == 0.0
    J_phi = controller.contacts.jacobian(kinematics(hrp2, measured.q))
    assert np.allclose(command.u, -15.0 * J_phi[14], atol=1e-9)


def test_torques_never_exceed_their_limits(hrp2, rng):
    q, _ = random_state(hrp2, rng, 0.1)
    controller = controller_at(hrp2, q)
    for k in range(50):
        wild = Measurement(q, rng.normal(size=hrp2.nv) * 100, rng.normal(size=18) * 1e4)
        command = controller.step(k * DT, wild, Reference(q, np.zeros(hrp2.nv), np.array([15.0])))
        assert np.all(np.abs(command.tau) <= hrp2.tau_max)
        assert np.isfinite(command.tau).all()
    assert command.status is ControlStatus.SATURATED


@pytest.mark.parametrize("field", ["q", "v", "lam"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_bad_measurement_keeps_the_last_torque(hrp2, rng, field, value):
    q, _ = random_state(hrp2, rng, 0.1)
    controller = controller_at(hrp2, q)
    command, measured = run_ticks(controller, hrp2, rng, q)
    before = controller.posture.integral_of_sign.copy()
    array = getattr(measured, field).copy()
    array[3] = value
    _, target = random_tick(hrp2, rng, q)
    held = controller.step(1.0, measured._replace(**{field: array}), target)
    assert held.status is ControlStatus.HELD
    assert np.array_equal(held.tau, command.tau)
    assert np.array_equal(controller.posture.integral_of_sign, before)


def test_wrong_shapes_are_refused_by_name(hrp2, rng):
    controller = controller_at(hrp2, hrp2.q_half_sitting)
    measured, target = random_tick(hrp2, rng, hrp2.q_half_sitting)
    with pytest.raises(ShapeError, match="measured lam"):
        controller.step(0.0, measured._replace(lam=np.zeros(3)), target)


def test_without_support_it_refuses(hrp2):
    floating = ContactStack([full_stack(hrp2, hrp2.q_half_sitting).contacts[2]])
    with pytest.raises(InputError, match="supports the base"):
        PassivityController(hrp2, floating, ControlGains(K_d=1.0), DT)


def test_a_clamped_joint_does_not_wind_up(hrp2):
    """A joint held off target with its torque at the limit: its integral stops, others go on."""
    q = hrp2.q_half_sitting
    controller = controller_at(hrp2, q)
    still, lam = np.zeros(hrp2.nv), np.zeros(18)
    joint = 6 + hrp2.joint_index("LARM_JOINT3")
    controller.step(0.0, Measurement(q, still, lam), Reference(q, still, np.array([0.0])))
    off = still.copy()
    off[joint] = 1.0
    pulled = pin.integrate(hrp2.model, q, off)
    for k in range(1, 400):
        command = controller.step(
            k * DT, Measurement(pulled, still, lam), Reference(q, still, np.array([0.0]))
        )
    assert abs(command.tau[joint - 6]) == hrp2.tau_max[joint - 6]
    clamped = abs(controller.posture.integral_of_sign[joint])
    free = PassivityController(
        replace(hrp2, model=_strong(hrp2)), controller.contacts, controller.gains, DT
    )
    free.step(0.0, Measurement(q, still, lam), Reference(q, still, np.array([0.0])))
    for k in range(1, 400):
        free.step(k * DT, Measurement(pulled, still, lam), Reference(q, still, np.array([0.0])))
    assert clamped < 0.5 * abs(free.posture.integral_of_sign[joint])


def _strong(robot):
    model = robot.model.copy()
    model.upperEffortLimit = np.full(robot.nv, 1e9)
    model.lowerEffortLimit = np.full(robot.nv, -1e9)
    return model


@pytest.mark.slow
@pytest.mark.parametrize(("alpha", "beta_p"), [(20.0, 5.0), (10.0, 3.0)])
def test_the_exponential_promise(hrp2, alpha, beta_p):
    """From an error in one arm dq follows d(dq)/dt + alpha dq = s_p(t0) exp(-beta_p t).

    Its solution: e0 (alpha exp(-beta_p t) - beta_p exp(-alpha t)) / (alpha - beta_p), as
    s_p(t0) = alpha e0 when the robot starts at rest.
    """
    q_ref = hrp2.q_half_sitting
    stack = ContactStack(sole_contacts(hrp2, q_ref))
    error = np.zeros(hrp2.nv)
    joint = 6 + hrp2.joint_index("LARM_JOINT3")
    error[joint] = 0.2
    engine = RigidContactEngine(hrp2, stack, pin.integrate(hrp2.model, q_ref, error), DT)
    K_d = advise_gains(hrp2, stack, q_ref, DT, alpha=alpha, kappa=300.0).K_d
    gains = ControlGains(
        K_d=K_d, alpha=alpha, beta_p=beta_p, k_ip=20.0, sgn_p=SignFunction("saturation", 0.1)
    )
    controller = PassivityController(hrp2, stack, gains, DT)
    state, still = engine.state, np.zeros(hrp2.nv)
    worst = 0.0
    for k in range(1000):
        t = k * DT
        dq = pin.difference(hrp2.model, q_ref, state.q)[joint]
        promise = 0.2 * (alpha * np.exp(-beta_p * t) - beta_p * np.exp(-alpha * t))
        worst = max(worst, abs(dq - promise / (alpha - beta_p)))
        measured = Measurement(state.q, state.v, state.lam)
        state = engine.step(controller.step(t, measured, Reference(q_ref, still, np.zeros(0))).tau)
    assert worst < 0.02 * 0.2


def test_who_shares_out_the_base_wrench_changes_nothing_else(hrp2, rng):
    """While no torque is clamped, u, s and both manifolds are the same bits; only F differs."""
    q, _ = random_state(hrp2, rng, 0.05)
    least, strong = controller_at(hrp2, q), replace(hrp2, model=_strong(hrp2))
    laws = [
        PassivityController(strong, least.contacts, least.gains, DT, bounds=bounds)
        for bounds in (None, ReactionBounds())
    ]
    apart = 0.0
    for k in range(20):
        measured, target = random_tick(hrp2, rng, q)
        measured.lam[[2, 8]] += 300.0
        own, other = (law.step(k * DT, measured, target) for law in laws)
        assert own.status is other.status is ControlStatus.RUN
        assert np.array_equal(own.u, other.u)
        assert np.array_equal(own.s, other.s)
        for one, two in zip(*((law.posture, law.force) for law in laws), strict=True):
            assert np.array_equal(one.memory, two.memory)
        J = least.contacts.jacobian(kinematics(hrp2, measured.q))[:12]
        for command in (own, other):
            assert np.allclose((command.u - J.T @ command.base_reaction)[6:], command.tau)
        apart = max(apart, np.abs(own.base_reaction - other.base_reaction).max())
    assert apart > 1.0


def test_only_feet_share_out_within_bounds(hrp2, rng):
    q, _ = random_state(hrp2, rng, 0.1)
    sole, other = sole_contacts(hrp2, q)
    slide = SurfaceContact(
        name="heel", supporting=True, frame=other.frame, surface=Plane(),
        T_world_surface=other.T_world_anchor,
    )  # fmt: skip
    with pytest.raises(InputError, match="only soles and feet that are points"):
        PassivityController(
            hrp2, ContactStack([sole, slide]), ControlGains(K_d=1.0), DT, bounds=ReactionBounds()
        )
