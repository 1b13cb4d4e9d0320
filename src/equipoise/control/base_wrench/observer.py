"""The reaction that would act without our own part of it: measured, and followed slowly.

The supporting reaction is `lam = lam_0 + F`: F is what the law added when it handed the base
wrench over. `lam_meas - F_previous` predicts lam_0, but taken at face value it closes a dead-beat
loop through the sensors. With a delay of d ticks the internal part x of the estimate obeys
`x_k = x_(k-1) + g (lam_0 - x_(k-1-d))`, which is stable only for `g < 2 sin(pi / (2 (2 d + 1)))`:
below 1 for one tick of delay, so that g = 1 does not survive even that. A low pass (g << 1) does.
"""

from __future__ import annotations

import numpy as np

from equipoise.spatial import Array
from equipoise.spatial.numbers import not_negative, require_period


class ReactionObserver:
    """Follows lam_0 with the time constant `filter_time` [s]; zero takes it at face value."""

    def __init__(self, filter_time: float, dt: float) -> None:
        self.gain = observer_gain(filter_time, dt)
        self.lam_0: Array | None = None

    def reset(self) -> None:
        """Forget; the next `update` starts at what it is given."""
        self.lam_0 = None

    def update(self, lam: Array, F: Array) -> Array:
        """Take the measured supporting reaction (k,) and the last `F` (k,); return lam_0 (k,)."""
        raw = lam - F
        if self.lam_0 is None:
            self.lam_0 = raw.copy()
        self.lam_0 = self.lam_0 + self.gain * (raw - self.lam_0)
        return self.lam_0


def observer_gain(filter_time: float, dt: float) -> float:
    """Return the share g of the difference that an observer takes over a tick of `dt` [s].

    Raises: `InputError` for a negative time or a period that is not positive.
    """
    filter_time, dt = not_negative("filter_time", filter_time, "s"), require_period(dt)
    return 1.0 if filter_time == 0.0 else float(-np.expm1(-dt / filter_time))


def largest_observer_gain(delay_ticks: int) -> float:
    """Return the gain below which the loop is stable with `delay_ticks` between F and lam."""
    return float(2.0 * np.sin(np.pi / (2.0 * (2.0 * delay_ticks + 1.0))))


def observer_delay_margin(filter_time: float, dt: float) -> float:
    """Return the largest delay [s], in whole ticks, that an observer survives."""
    gain, ticks = observer_gain(filter_time, dt), 0
    if not gain < largest_observer_gain(0):
        return 0.0
    while gain < largest_observer_gain(ticks + 1) and ticks < 10_000:
        ticks += 1
    return ticks * dt
