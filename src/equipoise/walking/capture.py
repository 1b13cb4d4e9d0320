"""A step elsewhere: where the foot in the air has to go so that it catches the divergent component.

Off its plan by e now, with a zero-moment point that is moved by dp, the divergent component will be
off by `(e - dp) exp(omega T) + dp` when the foot lands in T. A foot that lands as far aside finds
everything else as it was planned.
Source: Pratt, Carff, Drakunov and Goswami, "Capture point: a step toward humanoid push recovery",
2006; the step of a pendulum that is off by e. Differs: it is the reference that steps.
"""

from __future__ import annotations

import math

import numpy as np

from equipoise.spatial import Array
from equipoise.spatial.numbers import not_negative
from equipoise.walking.feet import LEFT
from equipoise.walking.foot_path import FootSample

QUICK = 12.0  # [1/s] rate of the critically damped lag with which a foot goes aside
SOON = 0.05  # [s] before a touchdown from which on a foot is not led elsewhere any more


class StepAside:
    """How far the foot in the air is from its planned way: `p` (2,) [m], `v` (2,) [m/s].

    `reach` [m] is how far it may be put elsewhere; zero: never.
    """

    def __init__(self, reach: float) -> None:
        self.reach = not_negative("how far a step may be put elsewhere", reach, "m")
        self.lift()

    def lift(self) -> None:
        """Begin a step: nothing is aside."""
        self.p, self.v, self.wanted = np.zeros(2), np.zeros(2), np.zeros(2)

    @property
    def acts(self) -> bool:
        """Whether the foot is, or will be, off its way."""
        return bool(self.wanted.any() or self.p.any() or self.v.any())

    def want(self, off: Array, foot: int, R: Array, left: float) -> None:
        """Put the foot where the divergent component will be, off by `off` (2,) [m], if it may.

        `R` (3, 3) are the axes of the foot, which may not be put nearer to the other; `left` [s] is
        the time until its touchdown.
        """
        if not self.reach or left < SOON:
            return
        ahead, aside = R[:2, :2].T @ off
        aside = max(aside, 0.0) if foot == LEFT else min(aside, 0.0)
        length = math.hypot(ahead, aside)
        share = min(1.0, self.reach / length) if length > 0.0 else 0.0
        self.wanted = share * (R[:2, :2] @ np.array([ahead, aside]))

    def advance(self, dt: float) -> None:
        """Go on by a tick `dt` [s], exactly."""
        decay, x = math.exp(-QUICK * dt), self.p - self.wanted
        b = self.v + QUICK * x
        self.p = self.wanted + (x + b * dt) * decay
        self.v = (b - QUICK * (x + b * dt)) * decay

    def moved(self, sample: FootSample) -> FootSample:
        """Return a foot as far aside of its way."""
        if not self.acts:
            return sample
        T, twist = sample.T_world_sole.copy(), sample.twist.copy()
        T.translation[:2] += self.p
        twist[:2] += self.v
        return FootSample(T, twist, sample.acceleration)

    def move_row(self, rate: float, row: Array) -> None:
        """Put a foot's pose row and twist (18,), of a clock that goes at `rate`, as far aside."""
        if self.acts:
            row[9:11] += self.p
            row[12:14] += rate * self.v
