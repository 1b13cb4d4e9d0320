"""The gains of a rival: the same few numbers for all, in terms of accelerations."""

from __future__ import annotations

from dataclasses import dataclass

from equipoise.control.passivity.gains import require_slow
from equipoise.spatial.numbers import not_negative, positive

RATES = ("kappa", "alpha", "contact_rate")


@dataclass(frozen=True)
class RivalGains:
    """Gains in [1/s], so that they say the same on every robot and in every rival.

    A posture error is wanted to die by `d dv/dt + kappa (dv + alpha dq + k_i z) = 0`, with
    `dz/dt = dv + alpha dq`; `k_i` zero is the form the authors published. Rivals without
    accelerations take the damping `kappa M(q_0)` and the stiffness `kappa alpha M(q_0)`. `k_f` is
    how fast the integral of the error of a regulated force answers, `contact_rate` how fast a
    violated contact is wanted to close, critically damped.
    """

    kappa: float = 100.0
    alpha: float = 20.0
    k_i: float = 0.0
    k_f: float = 5.0
    contact_rate: float = 10.0

    def __post_init__(self) -> None:
        for name in RATES:
            positive(f"gain {name} of a rival", getattr(self, name), "1/s")
        for name in ("k_i", "k_f"):
            not_negative(f"gain {name} of a rival", getattr(self, name), "1/s")


def require_slow_enough(gains: RivalGains, period: float) -> None:
    """Refuse gains that a loop of a period [s] would overshoot. Raises: `InputError`."""
    rates = {name: getattr(gains, name) for name in (*RATES, "k_i", "k_f")}
    require_slow(rates, period, " of a rival")
