"""How the run ended: whether it reached its duration, and the worst mode until then."""

from __future__ import annotations

from equipoise.analysis.metrics.base import Metric
from equipoise.analysis.run_context import RunContext


def _completed(context: RunContext) -> float:
    wanted = round(context.scenario.duration / context.scenario.control.period)
    return float(len(context.run.t) == wanted)


def _mode_worst(context: RunContext) -> float | None:
    return float(context.run["mode"].max()) if "mode" in context.run.names else None


METRICS = (
    Metric("completed", "", "1 if the run reached its duration", _completed),
    Metric("mode_worst", "", "0 run, 1 degraded, 2 safe, 3 stopped", _mode_worst),
)
