"""How a walk went: its steps, and what the torque did when the supports changed."""

from __future__ import annotations

import numpy as np

from equipoise.analysis.metrics.base import Metric
from equipoise.analysis.run_context import RunContext
from equipoise.spatial import Mask

CARRIES = "walk/carries"
STEPS = "walk/steps"


def _changes(context: RunContext) -> Mask | None:
    """Return the ticks (N - 1,) from the second on in which the supports changed."""
    if CARRIES not in context.run:
        return None
    return np.asarray((np.diff(context.run[CARRIES], axis=0) != 0.0).any(axis=1))


def _steps(context: RunContext) -> float | None:
    """Return how many steps ended on the ground; a foot that bounces or is lost counts once."""
    if STEPS in context.run:
        return float(context.run[STEPS].max())
    if CARRIES not in context.run:
        return None
    return float((np.diff(context.run[CARRIES], axis=0) > 0.0).sum())  # a log without the count


def _distance(context: RunContext) -> float | None:
    """Return how far [m] the base got over the ground."""
    if CARRIES not in context.run:
        return None
    q = context.run["q"]
    return float(np.hypot(*(q[-1, :2] - q[0, :2])))


def _switch_jump(context: RunContext) -> float | None:
    changes = _changes(context)
    if changes is None or not changes.any():
        return None
    return float(np.abs(np.diff(context.run["tau"], axis=0)[changes]).max())


METRICS = (
    Metric("walk_steps", "", "feet that were put down", _steps),
    Metric("walk_distance", "m", "how far the base got over the ground", _distance),
    Metric("switch_jump", "N m", "largest change of a torque as supports change", _switch_jump),
)
