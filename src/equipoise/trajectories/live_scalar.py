"""A number that is set while it is followed, by any thread, and never jumps."""

from __future__ import annotations

import numpy as np

from equipoise.compiled import compiled, entrance
from equipoise.spatial import Array
from equipoise.spatial.numbers import real_number
from equipoise.trajectories.base import instant
from equipoise.trajectories.posting import LONG_AGO, counts, faded, seconds
from equipoise.trajectories.scalar import LIVE, CompiledScalar

# numbers of a live scalar: how many were taken, the settings, the value; when the fade began, and
# the three derivatives of what is faded; then what is posted: its count and value
S_TAKEN, S_FADE, S_SMALL, S_VALUE, S_SINCE, S_OFFSET, S_POSTED = 0, 1, 2, 3, 4, 5, 8
SCALAR_COUNT = S_POSTED + 2


class LiveScalar(CompiledScalar):
    """A number, such as a wanted force, that is set while it is followed, from any thread.

    It goes from `start` (`value` itself if None) and from each `value` to the next over `fade` [s];
    a change of less than `small` is taken at once.
    Raises: `InputError`, `NonFiniteError`.
    """

    kind = LIVE

    def __init__(
        self, value: float, *, start: float | None = None, fade: float = 0.5, small: float = 0.5
    ) -> None:
        value = real_number("a live value", value)
        begin = value if start is None else real_number("the start of a live value", start)
        numbers = np.zeros(SCALAR_COUNT)
        numbers[S_FADE] = seconds("the fade of a live value", fade)
        numbers[S_SMALL] = real_number("the small change of a live value", small)
        numbers[S_VALUE], numbers[S_SINCE] = begin, LONG_AGO
        self._numbers = numbers
        self._posted = self._seen = numbers[S_POSTED:].copy()
        if begin != value:
            self.set(value)

    @property
    def value(self) -> float:
        """What was set last; setting it is `set`."""
        posted = self._posted
        return float(posted[1] if posted[0] else self._numbers[S_VALUE])

    @value.setter
    def value(self, value: float) -> None:
        self.set(value)

    def set(self, value: float) -> None:
        """Let this be wanted, from the next tick on. Raises: `InputError`, `NonFiniteError`."""
        self._posted = np.array([next(counts), real_number("a live value", value)])

    def post(self) -> None:
        """Hand what was set last to the numbers that the tick works with."""
        posted = self._posted
        if posted is not self._seen:
            self._numbers[S_POSTED:] = posted
            self._seen = posted

    def work_in(self, numbers: Array) -> None:
        """Keep the numbers from now on in an array that a kernel works with."""
        numbers[:] = self._numbers
        self._numbers = numbers

    @property
    def numbers(self) -> Array:
        """What the kernel needs, as it is now."""
        return self._numbers.copy()

    @property
    def least(self) -> float:
        """The lesser of what it is at first and what was set: a quintic from rest stays between."""
        return min(float(self._numbers[S_VALUE]), self.value)

    def at(self, t: float) -> float:
        """Return the value that a tick at time `t` [s] would want."""
        numbers = self._numbers.copy()
        numbers[S_POSTED:] = self._posted
        return live_scalar_alone(numbers, instant(t))


@compiled
def live_scalar_at(n: np.ndarray, t: float) -> float:
    """Return the value at time t; what is posted and not yet taken is taken first."""
    since = max(t - n[S_SINCE], 0.0)
    o, r, a = faded(n[S_OFFSET], n[S_OFFSET + 1], n[S_OFFSET + 2], n[S_FADE], since)
    if n[S_POSTED] == n[S_TAKEN]:
        return n[S_VALUE] + o
    n[S_TAKEN] = n[S_POSTED]
    jump = n[S_VALUE] - n[S_POSTED + 1]
    n[S_VALUE] = n[S_POSTED + 1]
    if abs(jump) <= n[S_SMALL]:
        return n[S_VALUE] + o
    n[S_SINCE] = t
    n[S_OFFSET], n[S_OFFSET + 1], n[S_OFFSET + 2] = o + jump, r, a
    return n[S_VALUE] + o + jump


@entrance
def live_scalar_alone(numbers: np.ndarray, t: float) -> float:
    """Return the value of one live scalar."""
    return live_scalar_at(numbers, t)
