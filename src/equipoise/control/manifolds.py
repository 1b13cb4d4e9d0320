"""The two error manifolds of the law, each with its whole memory in the open.

Integrals are explicit Euler sums at the control period, as a sampled controller computes them.
"""

from __future__ import annotations

import numpy as np

from equipoise.control.signum import SignFunction
from equipoise.spatial import Array


class PostureManifold:
    """Source: eq. (22a)-(22d). Differs from the print: time counts from t0 in (22b), and the
    argument of sgn is projected on the tangent space of the contacts, which is where s_qp lives
    when the contacts are rigid; what little of it is not (drift) then cannot wind the integral up.
    """

    def __init__(
        self, nv: int, *, alpha: float, beta_p: float, k_ip: float, sgn: SignFunction, bound: float
    ) -> None:
        self.alpha, self.beta_p, self.k_ip = alpha, beta_p, k_ip
        self.sgn = sgn
        self.bound = bound
        self.t0 = 0.0
        self.s_p0 = np.zeros(nv)
        self.integral_of_sign = np.zeros(nv)
        self.s_p = np.zeros(nv)
        self.s_qp = np.zeros(nv)
        self.s_rp = np.zeros(nv)

    def start(self, t: float, dq: Array, dv: Array) -> None:
        """Begin at time `t` [s]: s_qp is zero there, the integral is kept."""
        self.t0 = t
        self.s_p0 = dv + self.alpha * dq

    def update(self, t: float, dq: Array, dv: Array) -> Array:
        """Take the errors `dq`, `dv` (nv,) of time `t` [s]; return `s_rp` (nv,)."""
        self.s_p = dv + self.alpha * dq
        self.s_qp = self.s_p - self.s_p0 * np.exp(-self.beta_p * (t - self.t0))
        self.s_rp = self.s_qp + self.k_ip * self.integral_of_sign
        return self.s_rp

    def integrate(self, dt: float, s_qp_tangent: Array, held: Array) -> None:
        """Advance the integral of sgn by `dt` [s], except the components `held` (nv,) bool."""
        slope = np.where(held, 0.0, self.sgn(s_qp_tangent))
        advanced = self.integral_of_sign + dt * slope
        self.integral_of_sign = np.minimum(np.maximum(advanced, -self.bound), self.bound)


class ForceManifold:
    """Source: eq. (23a)-(23d). Differs from the print: time counts from t0 in (23b), and the
    integral of (23a) may be running when the manifold starts, so that s_dF need not vanish.
    """

    def __init__(self, size: int, *, beta_F: float, k_iF: float, sgn: SignFunction) -> None:
        self.beta_F, self.k_iF = beta_F, k_iF
        self.sgn = sgn
        self.t0 = 0.0
        self.s_F = np.zeros(size)
        self.s_F0 = np.zeros(size)
        self.integral_of_sign = np.zeros(size)
        self.s_qF = np.zeros(size)
        self.s_rF = np.zeros(size)
        self.rate_of_s_dF = np.zeros(size)

    def start(self, t: float) -> None:
        """Begin at time `t` [s] with the running integral s_F as starting value."""
        self.t0 = t
        self.s_F0 = self.s_F.copy()

    def update(self, t: float) -> Array:
        """Evaluate the manifold at time `t` [s]; return `s_rF` (k,)."""
        s_dF = self.s_F0 * np.exp(-self.beta_F * (t - self.t0))
        self.rate_of_s_dF = -self.beta_F * s_dF
        self.s_qF = self.s_F - s_dF
        self.s_rF = self.s_qF + self.k_iF * self.integral_of_sign
        return self.s_rF

    def integrate(self, dt: float, dlam: Array, held: bool) -> None:
        """Advance both integrals by `dt` [s] with the force error `dlam` (k,) [N, N m]."""
        if held:
            return
        self.integral_of_sign = self.integral_of_sign + dt * self.sgn(self.s_qF)
        self.s_F = self.s_F + dt * dlam
