"""The two error manifolds of the law, each with its whole memory in the open.

Integrals are explicit Euler sums at the control period, as a sampled controller computes them.
"""

from __future__ import annotations

import numpy as np

from equipoise.control.passivity.manifold_kernels import (
    GROWTH,
    INTEGRAL,
    INTEGRAL_F,
    RATE_OF_S_DF,
    S_F,
    S_F0,
    S_P,
    S_P0,
    S_QF,
    S_QP,
    S_RF,
    S_RP,
    force_integrate_alone,
    force_update_alone,
    posture_integrate_alone,
    posture_update_alone,
)
from equipoise.control.passivity.sign import SignFunction
from equipoise.spatial import Array

Variants = tuple[float, float, float]  # root, adapt, growth_max


class _Quantity:
    """A row of a manifold's memory, by name."""

    def __init__(self, row: int) -> None:
        self.row = row

    def __get__(self, manifold: _Manifold, kind: type | None = None) -> Array:
        return manifold.memory[self.row]

    def __set__(self, manifold: _Manifold, value: Array) -> None:
        manifold.memory[self.row] = value


class _Manifold:
    """What both have: a memory (quantities, size) and the time t0 they began at, `clock[place]`."""

    def __init__(self, memory: Array, clock: Array, place: int) -> None:
        self.memory = memory
        self._clock, self._place = clock, place

    @property
    def t0(self) -> float:
        """When it began [s]."""
        return float(self._clock[self._place])

    @t0.setter
    def t0(self, t: float) -> None:
        self._clock[self._place] = t


class PostureManifold(_Manifold):
    """Source: eq. (22a)-(22d). Differs from the print: time counts from t0 in (22b), and the
    argument of sgn is projected on the tangent space of the contacts, which is where s_qp lives
    when the contacts are rigid; what little of it is not (drift) then cannot wind the integral up.

    Two variants, off at zero. `root` adds the super-twisting term `root sgn(s) |s|^(1/2)` of s_qp,
    with a finite slope inside the layer of sgn. Source: Levant, Int. J. Control 58 (1993) 1247;
    Moreno and Osorio, IEEE TAC 57 (2012) 1035, whose generalised form keeps a linear term, too.
    `adapt` lets the slope k_ip grow outside that layer by up to `growth_max` times itself, and fall
    again inside. Source: Plestan, Shtessel, Bregeault and Poznyak, Int. J. Control 83 (2010) 1907;
    differs: the growth is bounded, and the rate is that of a saturated distance to the layer.

    `inside` tells whose memory it looks into: an array (6, nv), a clock and its place there.
    """

    s_p0, integral_of_sign = _Quantity(S_P0), _Quantity(INTEGRAL)
    s_p, s_qp, s_rp = _Quantity(S_P), _Quantity(S_QP), _Quantity(S_RP)
    growth = _Quantity(GROWTH)

    def __init__(
        self,
        nv: int,
        *,
        alpha: float,
        beta_p: float,
        k_ip: float,
        sgn: SignFunction,
        bound: float,
        variants: Variants = (0.0, 0.0, 0.0),
        inside: tuple[Array, Array, int] | None = None,
    ) -> None:
        super().__init__(*(inside or (np.zeros((6, nv)), np.zeros(1), 0)))
        self.root, self.adapt, self.growth_max = variants
        self.alpha, self.beta_p, self.k_ip = float(alpha), float(beta_p), float(k_ip)
        self.sgn = sgn
        self.bound = float(bound)

    def start(self, t: float, dq: Array, dv: Array) -> None:
        """Begin at time `t` [s]: s_qp is zero there, the integral is kept."""
        self.t0 = t
        self.s_p0 = dv + self.alpha * dq

    def update(self, t: float, dq: Array, dv: Array) -> Array:
        """Take the errors `dq`, `dv` (nv,) of time `t` [s]; return `s_rp` (nv,)."""
        age = float(t - self.t0)
        posture_update_alone(
            self.memory, dq, dv, age, self.alpha, self.beta_p, self.k_ip, self.root, self.sgn.layer
        )
        return self.s_rp

    def integrate(self, dt: float, s_qp_tangent: Array, held: Array) -> None:
        """Advance the integral of sgn by `dt` [s], except the components `held` (nv,) bool."""
        sgn = self.sgn
        posture_integrate_alone(
            self.memory, s_qp_tangent, held, dt, self.bound, sgn.code, sgn.layer,
            self.adapt, self.growth_max,
        )  # fmt: skip


class ForceManifold(_Manifold):
    """Source: eq. (23a)-(23d). Differs from the print: time counts from t0 in (23b), and the
    integral of (23a) may be running when the manifold starts, so that s_dF need not vanish.
    """

    s_F, s_F0, integral_of_sign = _Quantity(S_F), _Quantity(S_F0), _Quantity(INTEGRAL_F)
    s_qF, s_rF, rate_of_s_dF = _Quantity(S_QF), _Quantity(S_RF), _Quantity(RATE_OF_S_DF)

    def __init__(
        self,
        size: int,
        *,
        beta_F: float,
        k_iF: float,
        sgn: SignFunction,
        inside: tuple[Array, Array, int] | None = None,
    ) -> None:
        super().__init__(*(inside or (np.zeros((6, size)), np.zeros(1), 0)))
        self.beta_F, self.k_iF = float(beta_F), float(k_iF)
        self.sgn = sgn

    def start(self, t: float) -> None:
        """Begin at time `t` [s] with the running integral s_F as starting value."""
        self.t0 = t
        self.s_F0 = self.s_F

    def update(self, t: float) -> Array:
        """Evaluate the manifold at time `t` [s]; return `s_rF` (k,)."""
        force_update_alone(self.memory, float(t - self.t0), self.beta_F, self.k_iF)
        return self.s_rF

    def integrate(self, dt: float, dlam: Array) -> None:
        """Advance both integrals by `dt` [s] with the force error `dlam` (k,) [N, N m]."""
        force_integrate_alone(self.memory, dlam, dt, self.sgn.code, self.sgn.layer)
