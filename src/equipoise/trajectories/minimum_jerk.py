"""The minimum-jerk step: from rest to rest over a unit of time, with rate and bend."""

from __future__ import annotations

import math

from equipoise.compiled import inlined

FASTEST = 1.875  # greatest rate of the step, in its middle
SHARPEST = 10.0 / math.sqrt(3.0)  # greatest bend, on either side of it


@inlined
def step(x: float) -> float:
    """Return how far a step is at x in [0, 1]: 0 at its start, 1 at its end."""
    return x * x * x * (10.0 - 15.0 * x + 6.0 * x * x)


@inlined
def step_rate(x: float) -> float:
    """Return the first derivative of the step."""
    return 30.0 * x * x * (1.0 - x) * (1.0 - x)


@inlined
def step_bend(x: float) -> float:
    """Return the second derivative of the step."""
    return 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x)


@inlined
def share_of(t: float, start: float, end: float) -> float:
    """Return where t lies between start and end, cut at 0 and 1."""
    return min(max((t - start) / (end - start), 0.0), 1.0)
