"""Every metric by name. A new one is a line in its family's file, or a file and a line here."""

from __future__ import annotations

from equipoise.analysis.metrics import (
    balance,
    ending,
    forces,
    limits,
    objects,
    smoothness,
    tasks,
    tracking,
    walking,
)
from equipoise.analysis.metrics.base import Found, Metric
from equipoise.analysis.run_context import RunContext

METRICS: dict[str, Metric] = {
    metric.name: metric
    for family in (ending, tracking, tasks, forces, limits, balance, objects, walking, smoothness)
    for metric in family.METRICS
}
# names of version 0.1 that scenario files may still use
RENAMED = {
    "way_error": "path_error",
    "joint_room": "joint_margin",
    "contact_drift": "contact_violation",
}


def find_metrics(context: RunContext) -> dict[str, Found]:
    """Return every metric that applies to the run, by name, with its place in the run."""
    values = {}
    for metric in METRICS.values():
        value = metric.compute(context) if len(context.run.t) else None
        if value is not None:
            values[metric.name] = value if isinstance(value, Found) else Found(float(value))
    return values


def compute_metrics(context: RunContext) -> dict[str, float]:
    """Return every metric that applies to the run, by name."""
    return {name: found.value for name, found in find_metrics(context).items()}
