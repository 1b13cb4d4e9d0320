"""The table of what was achieved against what was wanted, and whether the run passed."""

from __future__ import annotations

from typing import Any

from equipoise.analysis.metrics.registry import METRICS, RENAMED, compute_metrics
from equipoise.analysis.run_context import RunContext
from equipoise.errors import NameNotFoundError
from equipoise.scenarios import schema
from equipoise.scenarios.lookup import at_path


def check_acceptance(scenario: schema.Scenario) -> None:
    """Refuse limits on metrics that do not exist. Raises: `ScenarioError`."""
    for name in scenario.acceptance.limits:
        if RENAMED.get(name, name) not in METRICS:
            path = f"acceptance.limits.{name}"
            raise at_path(NameNotFoundError("metric", name, METRICS), path)


def judge(context: RunContext) -> dict[str, dict[str, Any]]:
    """Return by metric: value, unit, doc, wanted bounds and, where some are wanted, `passed`.

    A wanted metric that does not apply to the run counts as not passed.
    """
    values = compute_metrics(context)
    limits = {
        RENAMED.get(name, name): limit for name, limit in context.scenario.acceptance.limits.items()
    }
    rows: dict[str, dict[str, Any]] = {}
    for name, metric in METRICS.items():
        if name not in values and name not in limits:
            continue
        row: dict[str, Any] = {"value": values.get(name), "unit": metric.unit, "doc": metric.doc}
        if name in limits:
            row["wanted"] = limits[name].model_dump(exclude_none=True)
            row["passed"] = _passes(values.get(name), limits[name])
        rows[name] = row
    return rows


def passed(rows: dict[str, dict[str, Any]]) -> bool:
    """Return whether every wanted row passed."""
    return all(row.get("passed", True) for row in rows.values())


def _passes(value: float | None, limit: schema.Limit) -> bool:
    if value is None:
        return False
    above = limit.min is None or value >= limit.min
    below = limit.max is None or value <= limit.max
    return above and below
