"""What the errors do on the sliding mode, in closed form: the exponential promise."""

from __future__ import annotations

import numpy as np

from equipoise.spatial import Array


def posture_error(
    t: Array | float, dq_0: Array | float, s_p0: Array | float, alpha: float, beta_p: float
) -> Array:
    """Return dq after `t` [s] on `s_qp = 0`: `d(dq)/dt + alpha dq = s_p0 exp(-beta_p t)`.

    `dq_0` is the error and `s_p0 = dv_0 + alpha dq_0` the manifold at t = 0.
    Source: eqs. (22a)-(22c) with s_qp = 0. Differs from the print: solved; for alpha = beta_p too.
    """
    t = np.asarray(t, dtype=float)
    gap = alpha - beta_p
    decay = np.exp(-alpha * t)
    forced = decay * (t if gap == 0.0 else np.expm1(gap * t) / gap)
    return dq_0 * decay + s_p0 * forced


def posture_error_rate(
    t: Array | float, dq_0: Array | float, s_p0: Array | float, alpha: float, beta_p: float
) -> Array:
    """Return dv after `t` [s] on `s_qp = 0`."""
    t = np.asarray(t, dtype=float)
    return s_p0 * np.exp(-beta_p * t) - alpha * posture_error(t, dq_0, s_p0, alpha, beta_p)


def force_error(t: Array | float, s_F0: Array | float, beta_F: float) -> Array:
    """Return dlam [N] after `t` [s] on `s_qF = 0`, for an integral `s_F0` [N s] that was running.

    Source: eqs. (23a)-(23c) with s_qF = 0. Differs from the print: time counts from t0, where the
    print's s_F is always zero.
    """
    return -beta_F * np.asarray(s_F0) * np.exp(-beta_F * np.asarray(t, dtype=float))
