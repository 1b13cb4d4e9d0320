"""The gains of the law, with the paper's letters and a table of what each does."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np

from equipoise.control.passivity.sign import SignFunction
from equipoise.errors import InputError
from equipoise.spatial import Array
from equipoise.spatial.numbers import real_array, real_number

Projector = Literal["euclidean", "damping"]


@dataclass(frozen=True)
class ControlGains:
    r"""Gains of (20)-(24). Scalars act on every component alike.

    | gain | unit | what it does |
    |---|---|---|
    | `K_d` | N m s/rad (nv, nv) | damping of the extended error s; stiffness is `K_d alpha` |
    | `alpha` | 1/s | how fast a posture error dies on the sliding mode |
    | `beta_p` | 1/s | how fast the starting value s_p(t0) is forgotten |
    | `k_ip` | rad/s^2 | slope of the integral of sgn(s_qp); must exceed the disturbance's rate |
    | `beta` | 1/kg | weight of the force error in s |
    | `beta_F` | 1/s | how fast the starting value s_F(t0) is forgotten |
    | `k_iF` | N | slope of the integral of sgn(s_qF), and size of the tanh term |
    | `mu` | 1/(N s) | steepness of the tanh term |
    | `eta` | 1/s | how fast the integrated force error dies |
    | `sgn_p`, `sgn_F` | | sign functions of the two integrals |
    | `root` | (rad/s)^(1/2) | super-twisting: weight of sgn(s_qp) \|s_qp\|^(1/2) beside s_qp |
    | `adapt` | 1/s | adaptive slope: how fast k_ip grows outside the layer of sgn_p, falls inside |
    | `growth_max` | | by how many times k_ip it grows at most |
    | `integral_max` | s | bound on each integral of sgn_p: it carries at most this times K_d k_ip |
    | `handover` | s | how fast the difference fades that a change of contacts would make |
    | `relax` | s | how fast the forces fade that supports exert on each other after a switch |
    | `damp_violation` | | add to s what violates contacts: zero on rigid ones, steadies soft ones |
    | `projector` | | `euclidean`: Q_phi as printed; `damping`: orthogonal in K_d, see docs/law |

    `K_d` may be a scalar, a vector (nv,) or a symmetric positive definite matrix (nv, nv).
    """

    K_d: Array | float
    alpha: float = 20.0
    beta_p: float = 5.0
    k_ip: float = 5.0
    beta: float = 0.05
    beta_F: float = 5.0
    k_iF: float = 5.0
    mu: float = 5.0
    eta: float = 20.0
    sgn_p: SignFunction = field(default_factory=SignFunction)
    sgn_F: SignFunction = field(default_factory=SignFunction)
    integral_max: float = 10.0
    root: float = 0.0
    adapt: float = 0.0
    growth_max: float = 4.0
    handover: float = 0.3
    relax: float = 0.03
    damp_violation: bool = False
    projector: Projector = "euclidean"

    def __post_init__(self) -> None:
        positive = ("alpha", "beta_p", "beta", "beta_F", "mu", "eta", "integral_max")
        for name in (*positive, "handover", "relax"):
            self._require_positive(name)
        for name in ("k_ip", "k_iF", "root", "adapt", "growth_max"):
            value = real_number(f"gain {name}", getattr(self, name), finite=False)
            if not (np.isfinite(value) and value >= 0.0):
                raise InputError(f"gain {name} must be finite and not negative", given=value)
            object.__setattr__(self, name, float(value))
        if self.root + self.adapt > 0.0 and not self.sgn_p.layer > 0.0:
            raise InputError(
                "root and adapt need a layer of sgn_p",
                given=self.sgn_p.layer,
                remedy="Take a saturation with a layer of 0.05 rad/s, say",
            )
        if self.projector not in get_args(Projector):
            raise InputError(
                "no such projector", given=self.projector, known=list(get_args(Projector))
            )
        K_d = real_array("gain K_d", self.K_d, None, finite=False)
        if not np.isfinite(K_d).all():
            raise InputError("gain K_d holds a NaN or an infinity")
        if K_d.ndim < 2 and not (K_d > 0.0).all():
            raise InputError("gain K_d must be positive", given=self.K_d)
        if K_d.ndim == 2:
            self._require_positive_definite(K_d)

    def _require_positive(self, name: str) -> None:
        value = real_number(f"gain {name}", getattr(self, name), finite=False)
        if not (np.isfinite(value) and value > 0.0):
            raise InputError(f"gain {name} must be finite and positive", given=value)
        object.__setattr__(self, name, float(value))

    @staticmethod
    def _require_positive_definite(K_d: Array) -> None:
        if K_d.shape[0] != K_d.shape[1] or not np.allclose(K_d, K_d.T):
            raise InputError("gain K_d must be square and symmetric", given=K_d.shape)
        smallest = float(np.linalg.eigvalsh(K_d)[0])
        if not smallest > 0.0:
            raise InputError("gain K_d must be positive definite", given=smallest)

    def damping_matrix(self, nv: int) -> Array:
        """Return `K_d` as a matrix (nv, nv)."""
        K_d = np.asarray(self.K_d, dtype=float)
        if K_d.ndim == 2:
            if K_d.shape != (nv, nv):
                raise InputError(f"gain K_d must be ({nv}, {nv})", given=K_d.shape)
            return K_d.copy()
        return np.diag(np.broadcast_to(K_d, (nv,)).astype(float))


def require_gains(gains: ControlGains, period: float) -> None:
    """Refuse gains that a loop of a period [s] would overshoot. Raises: `InputError`."""
    rates = {name: getattr(gains, name) for name in ("alpha", "beta_p", "beta_F", "eta")}
    require_slow(rates, period)


def require_slow(rates: Mapping[str, float], period: float, whose: str = "") -> None:
    """Refuse rates [1/s], by the name of their gain, above 1 / period [s]. Raises: `InputError`."""
    for name, rate in rates.items():
        if rate * period > 1.0 + 1e-9:
            raise InputError(
                f"gain {name}{whose} is too fast for the period: {rate:g} 1/s * {period:g} s = "
                f"{rate * period:.3g} > 1",
                given=rate,
                remedy=f"Give at most {1.0 / period:.6g} 1/s, or a shorter period",
            )
