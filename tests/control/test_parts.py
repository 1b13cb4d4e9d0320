"""Manifolds, sign functions, base wrench, profile, gains and adviser, each by itself."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg
from scipy.optimize import minimize

from equipoise.contacts import ContactStack
from equipoise.control import (
    ControlGains,
    ForceManifold,
    PostureManifold,
    SignFunction,
    advise_gains,
    distribute_base_wrench,
)
from equipoise.control.passivity.gain_advice import delay_margin, inertia_matrix
from equipoise.errors import InputError
from equipoise.trajectories import Profile
from helpers import full_stack, kinematics, sole_contacts


def test_posture_manifold_is_22(rng):
    """Against the four lines of (22) written out, with a trapezoid-free Euler integral."""
    manifold = PostureManifold(
        3, alpha=4.0, beta_p=2.0, k_ip=1.5, sgn=SignFunction("sign"), bound=10.0
    )
    t0, dt, total = 0.7, 0.01, np.zeros(3)
    history = [(rng.normal(size=3), rng.normal(size=3)) for _ in range(30)]
    manifold.start(t0, *history[0])
    nobody = np.zeros(3, dtype=bool)
    for k, (dq, dv) in enumerate(history):
        t = t0 + k * dt
        s_rp = manifold.update(t, dq, dv)
        s_p0 = history[0][1] + 4.0 * history[0][0]
        s_qp = dv + 4.0 * dq - s_p0 * np.exp(-2.0 * (t - t0))
        assert np.allclose(s_rp, s_qp + 1.5 * total, atol=1e-14)
        manifold.integrate(dt, s_qp, nobody)
        total = total + dt * np.sign(s_qp)


def test_force_manifold_is_23_with_a_running_integral(rng):
    manifold = ForceManifold(2, beta_F=3.0, k_iF=0.5, sgn=SignFunction("tanh", 0.2))
    manifold.s_F = np.array([0.3, -0.2])
    manifold.start(1.0)
    s_F, total, dt = manifold.s_F.copy(), np.zeros(2), 0.01
    for k in range(30):
        t = 1.0 + k * dt
        s_dF = np.array([0.3, -0.2]) * np.exp(-3.0 * (t - 1.0))
        assert np.allclose(manifold.update(t), s_F - s_dF + 0.5 * total, atol=1e-14)
        assert np.allclose(manifold.rate_of_s_dF, -3.0 * s_dF)
        dlam = rng.normal(size=2)
        total = total + dt * np.tanh((s_F - s_dF) / 0.2)
        s_F = s_F + dt * dlam
        manifold.integrate(dt, dlam)


def test_posture_integral_is_bounded_and_held():
    manifold = PostureManifold(
        2, alpha=1.0, beta_p=1.0, k_ip=1.0, sgn=SignFunction("sign"), bound=0.05
    )
    for _ in range(100):
        manifold.integrate(0.001, np.array([1.0, 1.0]), np.array([False, True]))
    assert manifold.integral_of_sign == pytest.approx([0.05, 0.0])


@pytest.mark.parametrize("kind", ["sign", "tanh", "saturation"])
def test_sign_functions_are_odd_bounded_and_agree_far_away(kind, rng):
    sgn = SignFunction(kind, 0.01)
    x = rng.normal(size=100)
    assert np.array_equal(sgn(-x), -sgn(x))
    assert np.abs(sgn(x)).max() <= 1.0
    assert np.allclose(sgn(np.array([-2.0, 0.0, 2.0])), [-1, 0, 1])


def test_base_wrench_is_the_cheapest_that_carries(hrp2, rng):
    """Against a general optimiser on the same problem."""
    stack = ContactStack(sole_contacts(hrp2, hrp2.q_half_sitting))
    J_base = stack.jacobian(kinematics(hrp2, hrp2.q_half_sitting))[:, :6]
    u_base, lam, costs = rng.normal(size=6) * 50, rng.normal(size=12) * 50, rng.uniform(1, 5, 12)
    F = distribute_base_wrench(u_base, J_base, costs, lam)
    assert np.allclose(J_base.T @ F, u_base, atol=1e-9)
    found = minimize(
        lambda f: np.sum((costs * (lam + f)) ** 2),
        np.zeros(12),
        jac=lambda f: 2 * costs**2 * (lam + f),
        constraints={
            "type": "eq",
            "fun": lambda f: J_base.T @ f - u_base,
            "jac": lambda f: J_base.T,
        },
        method="SLSQP",
        options={"maxiter": 500, "ftol": 1e-14},
    )
    assert np.allclose(F, found.x, atol=1e-3 * np.abs(F).max())


def test_profile_holds_steps_and_is_smooth():
    profile = Profile.of([0.5, 1.5, 2.0], [0.0, 20.0, 5.0])
    assert profile.at(0.0) == 0.0
    assert profile.at(1.0) == pytest.approx(10.0)
    assert profile.at(1.5) == pytest.approx(20.0)
    assert profile.at(9.0) == 5.0
    t = np.linspace(0, 3, 30001)
    values = np.array([profile.at(x) for x in t])
    assert np.abs(np.diff(values, 2)).max() < 1e-4


@pytest.mark.parametrize(
    ("name", "value"), [("alpha", 0.0), ("beta", -1.0), ("eta", np.nan), ("k_ip", -1.0)]
)
def test_senseless_gains_are_refused_by_name(name, value):
    with pytest.raises(InputError, match=name):
        ControlGains(K_d=1.0, **{name: value})


@pytest.mark.parametrize("K_d", [-1.0, np.diag([1.0, -1.0]), np.array([[1.0, 2.0], [0.0, 1.0]])])
def test_damping_must_be_positive_definite(K_d):
    with pytest.raises(InputError, match="K_d"):
        ControlGains(K_d=K_d)


@pytest.mark.parametrize(("share", "stable"), [(0.95, True), (1.05, False)])
def test_the_bound_on_rigid_contacts_is_sharp(hrp2, share, stable):
    """Iterate v <- v - dt M_t^-1 K_t v on the tangent space just below and above the bound."""
    stack = full_stack(hrp2, hrp2.q_half_sitting)
    dt = 1e-3
    advice = advise_gains(hrp2, stack, hrp2.q_half_sitting, dt, alpha=20.0, kappa=100.0)
    Z = scipy.linalg.null_space(stack.jacobian(kinematics(hrp2, hrp2.q_half_sitting)))
    M = Z.T @ inertia_matrix(hrp2, hrp2.q_half_sitting) @ Z
    K = Z.T @ advice.K_d @ Z * (share * advice.kappa_max_rigid / advice.kappa)
    step = np.eye(len(M)) - dt * np.linalg.solve(M, K)
    grown = np.abs(np.linalg.matrix_power(step, 400)).max()
    assert (grown < 1.0) == stable


def test_diagonal_damping_has_a_larger_ratio(hrp2):
    stack = full_stack(hrp2, hrp2.q_half_sitting)
    advice = advise_gains(hrp2, stack, hrp2.q_half_sitting, 1e-3, alpha=20.0)
    assert advice.ratio_diagonal > 5.0
    free = advice.kappa_max_free
    assert free["euclidean"] < 0.1 * free["damping"] <= 0.101 * advice.kappa_max_rigid
    assert len(advice.sentences()) == 4


@pytest.mark.parametrize("factor", [0.9, 1.1])
def test_delay_margin_against_a_simulated_loop(factor):
    """q'' = -kappa (q' + alpha q) with a delayed measurement: stable below the margin only."""
    kappa, alpha = 50.0, 10.0
    h = 1e-4
    delay = round(factor * delay_margin(kappa, alpha) / h)
    q, v, past = 1.0, 0.0, [(1.0, 0.0)] * (delay + 1)
    for _ in range(30000):
        old_q, old_v = past.pop(0)
        v -= h * kappa * (old_v + alpha * old_q)
        q += h * v
        past.append((q, v))
    assert (abs(q) < 1.0) == (factor < 1.0)


def test_rotors_are_given_as_one_number_or_one_a_joint(hrp2):
    stack = ContactStack(sole_contacts(hrp2, hrp2.q_half_sitting))

    def advised(inertia):
        return advise_gains(
            hrp2, stack, hrp2.q_half_sitting, 1e-3, alpha=20.0, kappa=100.0, rotor_inertia=inertia
        ).K_d

    assert np.array_equal(advised(0.02), advised(np.full(hrp2.na, 0.02)))
    for wrong in (-0.1, np.nan, np.full(hrp2.na, -0.1), np.zeros(3)):
        with pytest.raises(InputError):
            advised(wrong)
