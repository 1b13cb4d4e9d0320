"""Regressor, error dynamics and closed forms by themselves, on random states."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from scipy.integrate import solve_ivp

from equipoise.control import ControlGains
from equipoise.errors import ShapeError
from equipoise.verify.closed_forms import force_error, posture_error, posture_error_rate
from equipoise.verify.error_dynamics import (
    Dynamics,
    dynamic_parameters,
    error_force,
    inertia,
    power_balance,
    reference_regressor,
    regressor,
)
from helpers import random_state


def test_regressor_times_parameters_is_the_inverse_dynamics(hrp2, rng):
    q, v = random_state(hrp2, rng)
    a = rng.normal(size=hrp2.nv)
    expected = pin.rnea(hrp2.model, hrp2.model.createData(), q, v, a)
    given = regressor(hrp2, q, v, a) @ dynamic_parameters(hrp2)
    assert np.allclose(given, expected, atol=1e-10 * np.abs(expected).max())


def test_the_regressor_knows_no_parameter(hrp2, rng):
    """The same Y for a robot with other masses, whose own Theta then gives its own dynamics."""
    q, v = random_state(hrp2, rng)
    a = rng.normal(size=hrp2.nv)
    other = hrp2.scaled(1.7).with_payload(hrp2.palms[0].frame, 3.0)
    Y = regressor(hrp2, q, v, a)
    assert np.allclose(Y, regressor(other, q, v, a), atol=1e-10)
    expected = pin.rnea(other.model, other.model.createData(), q, v, a)
    assert np.allclose(Y @ dynamic_parameters(other), expected, atol=1e-9 * np.abs(expected).max())


def test_reference_regressor_at_the_velocity_itself_is_the_regressor(hrp2, rng):
    q, v = random_state(hrp2, rng)
    a = rng.normal(size=hrp2.nv)
    Y, Y_r = regressor(hrp2, q, v, a), reference_regressor(hrp2, q, v, v, a)
    assert np.allclose(Y, Y_r, atol=1e-9)


def test_error_dynamics_19(hrp2, rng):
    """M ds/dt + (C + D) s = generalised force - Y_r Theta, whatever v_r and its rate are."""
    q, v = random_state(hrp2, rng)
    a, v_r, a_r = rng.normal(size=(3, hrp2.nv))
    dynamics = Dynamics.at(hrp2, q, v, joint_damping=2.0)
    force = dynamics.M @ a + dynamics.bias(v)
    Y_r_theta = reference_regressor(hrp2, q, v, v_r, a_r) @ dynamic_parameters(hrp2)
    right = force - Y_r_theta - dynamics.D @ v_r
    left = error_force(dynamics, v - v_r, a - a_r)
    assert np.allclose(left, right, atol=1e-10 * np.abs(force).max())


def test_power_of_28_is_the_rate_of_27(hrp2, rng):
    """With a free s and s_rF: dV/dt by the dynamics against the terms, D and signs included."""
    q, v = random_state(hrp2, rng)
    s, a_r, v_r = rng.normal(size=(3, hrp2.nv))
    s_rF, s_qF, sign = rng.normal(size=(3, 1))
    beta, eta, k_iF, mu = 0.3, 4.0, 1.5, 2.0
    dynamics, K_d = Dynamics.at(hrp2, q, v, joint_damping=2.0), 100.0 * np.eye(hrp2.nv)
    gains = ControlGains(K_d=K_d, beta=beta, eta=eta, k_iF=k_iF, mu=mu)
    row = rng.normal(size=(1, hrp2.nv))
    s = s - np.linalg.pinv(row) @ (row @ s + beta * s_rF)  # s^T J^T = -beta s_rF^T
    s_rF_rate = rng.normal(size=1)
    Z_F = eta * s_rF + s_rF_rate - k_iF * sign + k_iF * np.tanh(mu * s_qF)
    reference = dynamics.reference_force(v_r, a_r)
    pull = row.T @ Z_F - reference - (dynamics.C + dynamics.D + K_d) @ s
    step = 1e-6
    ahead, behind = (inertia(hrp2, pin.integrate(hrp2.model, q, x * step * v)) for x in (1, -1))
    M_rate = (ahead - behind) / (2 * step)
    V_rate = s @ pull + 0.5 * s @ M_rate @ s + beta * s_rF @ s_rF_rate
    terms = power_balance(dynamics, gains, s, reference, s_rF=s_rF, s_qF=s_qF, sign=sign)
    assert np.isclose(V_rate, terms.rate, atol=1e-6 * terms.throughput)


@pytest.mark.parametrize(("alpha", "beta_p"), [(20.0, 5.0), (10.0, 10.0), (3.0, 8.0), (4.0, 4.001)])
def test_closed_form_of_the_posture_is_what_an_integrator_finds(alpha, beta_p):
    t = np.linspace(0.0, 1.0, 11)
    found = solve_ivp(
        lambda x, e: -alpha * e + 1.7 * np.exp(-beta_p * x),
        (0.0, 1.0),
        [0.2],
        t_eval=t,
        rtol=1e-10,
        atol=1e-12,
    ).y[0]
    given = posture_error(t, 0.2, 1.7, alpha, beta_p)
    assert np.allclose(given, found, atol=1e-8)
    slope = -alpha * given + 1.7 * np.exp(-beta_p * t)
    assert np.allclose(posture_error_rate(t, 0.2, 1.7, alpha, beta_p), slope)


def test_closed_form_of_the_force_integrates_to_the_dying_integral():
    """s_F = s_F0 exp(-beta_F t) on s_qF = 0, and dlam is its rate."""
    t = np.linspace(0.0, 2.0, 2001)
    dlam = force_error(t, 0.7, 3.0)
    steps = 0.5 * np.diff(t) * (dlam[1:] + dlam[:-1])
    s_F = 0.7 + np.concatenate(([0.0], np.cumsum(steps)))
    assert np.allclose(s_F, 0.7 * np.exp(-3.0 * t), atol=1e-6)


def test_wrong_shapes_are_refused(hrp2):
    still = np.zeros(hrp2.nv)
    with pytest.raises(ShapeError, match="a has shape"):
        regressor(hrp2, hrp2.q_half_sitting, still, np.zeros(3))
