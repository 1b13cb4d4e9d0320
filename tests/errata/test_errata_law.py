"""Errata of the law and of its proof: each printed form fails, each repaired form passes."""

from __future__ import annotations

import numpy as np
import pytest

from equipoise.control import ForceManifold, PostureManifold, SignFunction
from equipoise.verify.closed_forms import force_error
from equipoise.verify.error_dynamics import force_error_drive

ETA, K_IF, MU = 4.0, 1.5, 2.0


def running_manifold(rng) -> tuple[ForceManifold, np.ndarray]:
    """Return a force manifold that was handed a running integral, at a later tick, and its dlam."""
    manifold = ForceManifold(2, beta_F=3.0, k_iF=K_IF, sgn=SignFunction("saturation", 0.3))
    manifold.s_F = np.array([0.4, -0.2])
    manifold.start(0.0)
    dlam = rng.normal(size=2)
    for k in range(20):
        manifold.update(k * 1e-3)
        manifold.integrate(1e-3, dlam)
    manifold.update(20e-3)
    return manifold, dlam


@pytest.mark.parametrize("printed", [True, False])
def test_24_subtracts_the_rate_of_s_dF(rng, printed):
    """(24) prints `+ ds_dF/dt`; only with `-` does J^T lam + J^T(...) become J^T Z_F of (26).

    s_rF' = dlam - s_dF' + k sgn(s_qF), so dlam - s_dF' + k tanh + eta s_rF is Z_F.
    """
    manifold, dlam = running_manifold(rng)
    sign = manifold.sgn(manifold.s_qF)
    rate = dlam - manifold.rate_of_s_dF + K_IF * sign
    Z_F = force_error_drive(manifold.s_rF, rate, manifold.s_qF, sign, eta=ETA, k_iF=K_IF, mu=MU)
    s_dF_term = manifold.rate_of_s_dF if printed else -manifold.rate_of_s_dF
    law = s_dF_term + K_IF * np.tanh(MU * manifold.s_qF) + ETA * manifold.s_rF
    assert np.allclose(dlam + law, Z_F, atol=1e-12) is not printed


@pytest.mark.parametrize("printed", [True, False])
def test_24_only_then_the_force_follows_its_closed_form(printed):
    """On an ideal robot, lam = lam_ref less the other terms, the sign decides."""
    manifold = ForceManifold(1, beta_F=5.0, k_iF=0.0, sgn=SignFunction("sign"))
    manifold.s_F = np.array([1.0])
    manifold.start(0.0)
    dt, worst = 1e-4, 0.0
    for k in range(2000):
        s_rF = manifold.update(k * dt)
        s_dF_term = manifold.rate_of_s_dF if printed else -manifold.rate_of_s_dF
        dlam = -(s_dF_term + ETA * s_rF)
        worst = max(worst, float(np.abs(dlam - force_error(k * dt, 1.0, 5.0)).max()))
        manifold.integrate(dt, dlam)
    assert (worst < 0.01 * 5.0) is not printed


@pytest.mark.parametrize("printed", [True, False])
def test_26_has_the_gain_before_the_sign(rng, printed):
    """(26) prints `- sgn(s_qF)`; substituting (24) into (19) leaves `- k_iF sgn(s_qF)`."""
    manifold, dlam = running_manifold(rng)
    sign = manifold.sgn(manifold.s_qF)
    rate = dlam - manifold.rate_of_s_dF + K_IF * sign
    substituted = (
        dlam - manifold.rate_of_s_dF + K_IF * np.tanh(MU * manifold.s_qF) + ETA * manifold.s_rF
    )
    gain = 1.0 if printed else K_IF
    Z_F = ETA * manifold.s_rF + rate - gain * sign + K_IF * np.tanh(MU * manifold.s_qF)
    assert np.allclose(Z_F, substituted, atol=1e-12) is not printed


@pytest.mark.parametrize("printed", [True, False])
def test_reaching_time_is_over_k_less_delta(printed):
    """ds_q/dt = d - k sgn(s_q), |d| <= delta < k: it reaches zero, so the bound is positive."""
    k, delta, dt, s_q, t = 5.0, 2.0, 1e-4, 1.0, 0.0
    bound = s_q / ((delta - k) if printed else (k - delta))
    while s_q > 0.0:
        s_q += dt * (delta - k)
        t += dt
    assert (t <= bound + dt) is not printed


@pytest.mark.parametrize("printed", [True, False])
def test_22b_and_23b_count_time_from_t0(rng, printed):
    """`s_dp = s_p(t0) exp(-beta t)` makes s_qp(t0) = 0 only if t counts from t0."""
    t0, dq, dv = 2.0, rng.normal(size=3), rng.normal(size=3)
    manifold = PostureManifold(
        3, alpha=4.0, beta_p=3.0, k_ip=1.0, sgn=SignFunction("sign"), bound=1.0
    )
    manifold.start(t0, dq, dv)
    if printed:
        manifold.t0 = 0.0
    manifold.update(t0, dq, dv)
    assert (np.abs(manifold.s_qp).max() < 1e-12) is not printed


def test_23_never_has_a_start_to_forget_as_printed():
    """(23a) starts its integral at t0, so s_F(t0) = 0 and s_dF vanishes for good."""
    manifold = ForceManifold(1, beta_F=3.0, k_iF=1.0, sgn=SignFunction("sign"))
    manifold.start(1.0)
    for k in range(5):
        manifold.update(1.0 + k * 0.1)
        manifold.integrate(0.1, np.array([7.0]))
        assert manifold.rate_of_s_dF[0] == 0.0
    assert manifold.s_F[0] == pytest.approx(3.5)


@pytest.mark.parametrize("k", [1.0, 5.0])
def test_the_sliding_mode_is_promised_only_for_a_gain_above_the_disturbance(k):
    """A disturbance of rate 3: with k = 5 s_q stays in the layer, with k = 1 it runs away."""
    layer, dt, s_q, integral = 0.05, 1e-4, 0.0, 0.0
    sgn = SignFunction("saturation", layer)
    for n in range(20000):
        s_r = 3.0 * n * dt  # what the dynamics make of s_r
        s_q = s_r - k * integral
        integral += dt * float(sgn(np.array([s_q]))[0])
    assert (abs(s_q) <= layer) is (k > 3.0)
