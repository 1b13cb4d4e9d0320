"""How much of a task counts at a time: it comes and goes over a ramp instead of at once."""

from __future__ import annotations

import math
from dataclasses import dataclass

from equipoise.errors import InputError

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

    def weight(self, t: float) -> float:
        """Return how much the task counts at time `t` [s]: 0 outside, 1 inside, between on ramps.

        The window is half open: the end does not count, as that of a contact.
        """
        if not self.start <= t < self.end:
            return 0.0
        if self.ramp == 0.0:
            return 1.0
        return _step(min(t - self.start, self.end - t) / self.ramp)


def _step(x: float) -> float:
    """Return the minimum-jerk step from 0 at x = 0 to 1 at x = 1, but for rounding, and beyond."""
    if x > 1.0 - ROUNDING:
        return 1.0
    return x**3 * (10.0 - 15.0 * x + 6.0 * x * x)
