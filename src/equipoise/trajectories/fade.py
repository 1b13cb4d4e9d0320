"""How much of a task counts at a time: it comes and goes over a ramp instead of at once."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from equipoise.compiled import compiled, entrance
from equipoise.errors import InputError
from equipoise.spatial.numbers import real_number
from equipoise.trajectories.base import instant
from equipoise.trajectories.minimum_jerk import step

ROUNDING = 1e-9


@dataclass(frozen=True)
class Fade:
    """Counts from `start` to `end` [s], fully but for a ramp of `ramp` [s] inside at either end.

    The ramps are minimum-jerk steps. Without a ramp the task is switched. `start` may be -inf and
    `end` +inf: then it was always there, or it stays.
    Raises: InputError if both ramps do not fit in.
    """

    start: float = -math.inf
    end: float = math.inf
    ramp: float = 0.3

    def __post_init__(self) -> None:
        for name in ("start", "end", "ramp"):
            real_number(f"the {name} of a fade", getattr(self, name), finite=False)
        if not self.start < self.end:
            raise InputError(
                "a task's window must end after it starts", given=(self.start, self.end)
            )
        if not self.ramp >= 0.0 or not self.end - self.start >= 2.0 * self.ramp:
            raise InputError(
                "the ramps at the ends of a task's window must fit into it",
                given=(self.start, self.end, self.ramp),
                remedy="Give a ramp from 0 to half the length of the window",
            )

    @property
    def numbers(self) -> np.ndarray:
        """Start, end and ramp (3,) [s]."""
        return np.array([self.start, self.end, self.ramp], dtype=float)

    def weight(self, t: float) -> float:
        """Return how much the task counts at time `t` [s]: 0 outside, 1 inside, between on ramps.

        The window is half open: the end does not count, as that of a contact.
        """
        return fade_alone(self.numbers, instant(t))


@compiled
def fade_weight(numbers: np.ndarray, t: float) -> float:
    """Return how much what has a fade (start, end, ramp) counts at time t."""
    start, end, ramp = numbers[0], numbers[1], numbers[2]
    if not start <= t < end:
        return 0.0
    x = min(t - start, end - t)
    if ramp == 0.0 or x > (1.0 - ROUNDING) * ramp:
        return 1.0
    return step(x / ramp)


@entrance
def fade_alone(numbers: np.ndarray, t: float) -> float:
    """Return the weight of one fade."""
    return fade_weight(numbers, t)
