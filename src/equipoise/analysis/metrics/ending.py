"""How the run ended: whether it reached its duration, and the worst mode until then."""

from __future__ import annotations

import numpy as np

from equipoise.analysis.metrics.base import Found, Metric, least, most
from equipoise.analysis.run_context import RunContext


def _completed(context: RunContext) -> float:
    wanted = round(context.scenario.duration / context.scenario.control.period)
    return float(len(context.run.t) == wanted)


def _mode(context: RunContext) -> Found | None:
    if "mode" not in context.run.names:
        return None
    return most([context.run["mode"][:, 0]], [""])


def _finite(context: RunContext) -> Found:
    """Say of every tick whether state and torques are numbers."""
    whole = np.ones(len(context.run.t), dtype=bool)
    for name in ("q", "v", "tau"):
        whole &= np.isfinite(context.run[name]).all(axis=1)
    return least([whole.astype(float)], [""]) or Found(1.0)


METRICS = (
    Metric("completed", "", "1 if the run reached its duration", _completed),
    Metric("mode_worst", "", "0 run, 1 degraded, 2 safe, 3 stopped", _mode),
    Metric("finite", "", "1 if every number of state and torque is finite", _finite),
)
