"""The clock of a walk: it goes with the time, and slows without a jerk while a foot is late."""

from __future__ import annotations

import math

from equipoise.spatial.numbers import positive, real_number, share

SETTLES = 4.74  # time constants in which a critically damped lag has covered 95 % of its way


class WalkClock:
    """Time of the plan [s] and its rate, which follows `wanted` within `fall` [s].

    The rate is a critically damped lag of second order, solved exactly over each tick, so that
    time, rate and its derivative are continuous. It never stands: `least` is what it is slowed to.
    Raises: `InputError`.
    """

    def __init__(self, start: float = 0.0, *, fall: float = 0.15, least: float = 0.05) -> None:
        self.t = real_number("the start of the clock", start)
        self._decay = SETTLES / positive("the time in which the clock slows", fall, "s")
        self.least = share("the least rate of the clock", least)
        self.rate, self.bend = 1.0, 0.0
        self.slowed = False

    def advance(self, dt: float) -> float:
        """Go on by a tick `dt` [s]; return the time of the plan [s] after it."""
        goal = self.least if self.slowed else 1.0
        k, x, y = self._decay, self.rate - goal, self.bend
        decay = math.exp(-k * dt)
        b = y + k * x
        # x(s) = (x + b s) exp(-k s), and its integral over the tick
        self.t += goal * dt + x * (1.0 - decay) / k + b * (1.0 - decay * (1.0 + k * dt)) / k**2
        self.rate = goal + (x + b * dt) * decay
        self.bend = (b - k * (x + b * dt)) * decay
        return self.t
