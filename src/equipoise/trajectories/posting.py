"""What is set from any thread and taken by a tick: its count, and what is left of a jump."""

from __future__ import annotations

import itertools

from equipoise.compiled import compiled
from equipoise.errors import InputError
from equipoise.spatial.numbers import real_number

LONG_AGO = -1e9  # [s]
counts = itertools.count(1)  # `next` of it is one step for every thread


def seconds(what: str, value: float) -> float:
    """Return a time [s] that is positive. Raises: `InputError`."""
    number = real_number(what, value)
    if not number > 0.0:
        raise InputError(f"{what} must be positive", given=value, remedy="Give seconds")
    return number


@compiled
def faded(o: float, r: float, a: float, span: float, s: float) -> tuple[float, float, float]:
    """Return value, rate and bend, at s, of what goes from (o, r, a) to rest at zero in `span`."""
    if s >= span:
        return 0.0, 0.0, 0.0
    x, r, a = s / span, r * span, 0.5 * a * span * span
    c3 = -10.0 * o - 6.0 * r - 3.0 * a
    c4 = 15.0 * o + 8.0 * r + 3.0 * a
    c5 = -6.0 * o - 3.0 * r - a
    return (
        o + x * (r + x * (a + x * (c3 + x * (c4 + x * c5)))),
        (r + x * (2.0 * a + x * (3.0 * c3 + x * (4.0 * c4 + x * 5.0 * c5)))) / span,
        (2.0 * a + x * (6.0 * c3 + x * (12.0 * c4 + x * 20.0 * c5))) / (span * span),
    )
