"""The table of what was achieved against what was wanted, and whether the run passed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from equipoise.analysis.metrics.always import ALWAYS
from equipoise.analysis.metrics.base import Found
from equipoise.analysis.metrics.registry import METRICS, RENAMED, find_metrics
from equipoise.analysis.run_context import RunContext
from equipoise.errors import NameNotFoundError
from equipoise.scenarios import schema
from equipoise.scenarios.lookup import at_path
from equipoise.spatial import Array

Row = dict[str, Any]


def check_acceptance(scenario: schema.Scenario) -> None:
    """Refuse limits on metrics that do not exist. Raises: `ScenarioError`."""
    for name in scenario.acceptance.limits:
        if RENAMED.get(name, name) not in METRICS:
            path = f"acceptance.limits.{name}"
            raise at_path(NameNotFoundError("metric", name, METRICS), path)


def judge(context: RunContext) -> dict[str, Row]:
    """Return by metric: value, unit, doc, wanted bounds and, where some are wanted, `passed`.

    Besides what the file wants, nothing impossible may have happened (`always`). A file that allows
    more of it has it in `loosened`: the bound that would hold. Where it was not kept, `fault` says
    in words what happened, `since` [s] when it began, `ticks` how often, `who` at what.
    A metric that the file wants and that does not apply to the run counts as not passed.
    """
    found = find_metrics(context)
    asked = {
        RENAMED.get(name, name): limit for name, limit in context.scenario.acceptance.limits.items()
    }
    rows: dict[str, Row] = {}
    for name, metric in METRICS.items():
        if name not in found and name not in asked:
            continue
        result = found.get(name)
        value = None if result is None else result.value
        row: Row = {"value": value, "unit": metric.unit, "doc": metric.doc}
        always = ALWAYS[name].limit if name in ALWAYS and result is not None else None
        limit, loosened = _together(asked.get(name), always)
        if limit is not None:
            row["wanted"] = limit.model_dump(exclude_none=True)
            row["passed"] = _passes(value, limit)
            if loosened:
                row["loosened"] = loosened
            if result is not None and not row["passed"]:
                row |= _place(result, limit, context.run.t)
                if name in ALWAYS:
                    row["fault"] = ALWAYS[name].fault
        rows[name] = row
    return rows


def passed(rows: Mapping[str, Mapping[str, Any]]) -> bool:
    """Return whether every wanted row passed."""
    return all(row.get("passed", True) for row in rows.values())


def impossible(rows: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """Return in sentences what happened that cannot be: what, at what, from when on."""
    sentences = []
    for row in rows.values():
        if row.get("passed", True) or "fault" not in row:
            continue
        sentence = str(row["fault"])
        if row.get("who"):
            sentence += f" ({row['who']})"
        if row.get("since") is not None:
            ticks = int(row["ticks"])
            sentence += (
                f", first at t = {float(row['since']):.3f} s, on {ticks} tick{'s' * (ticks > 1)}"
            )
        sentences.append(sentence)
    return sentences


def where_to_look(rows: Mapping[str, Mapping[str, Any]], folder: object) -> str:
    """Return the command that shows the first impossible moment, "" if there is none."""
    times = [
        float(row["since"])
        for row in rows.values()
        if "fault" in row and not row.get("passed", True) and row.get("since") is not None
    ]
    if not times:
        return ""
    return f"equipoise explain {folder} --at {min(times):.3f}, or equipoise view {folder}"


def _together(
    asked: schema.Limit | None, always: schema.Limit | None
) -> tuple[schema.Limit | None, dict[str, float]]:
    """Return the bounds that count, and those of `always` that a file has loosened.

    A side that the file leaves open stays as it always is.
    """
    if asked is None or always is None:
        return (asked if always is None else always), {}
    low = always.min if asked.min is None else asked.min
    high = always.max if asked.max is None else asked.max
    loosened = {}
    if always.min is not None and low is not None and low < always.min:
        loosened["min"] = always.min
    if always.max is not None and high is not None and high > always.max:
        loosened["max"] = always.max
    return schema.Limit(min=low, max=high), loosened


def _place(found: Found, limit: schema.Limit, t: Array) -> Row:
    """Return from when on, on how many ticks and at what a bound was not kept."""
    if found.series is None or len(found.series) != len(t):
        return {}
    beyond = ~np.isfinite(found.series)
    if limit.min is not None:
        beyond |= found.series < limit.min
    if limit.max is not None:
        beyond |= found.series > limit.max
    where = np.flatnonzero(beyond)
    if not where.size:
        return {}
    first = int(where[0])
    place: Row = {"since": float(t[first]), "ticks": int(where.size)}
    if len(found.names):
        place["who"] = found.names[first]
    return place


def _passes(value: float | None, limit: schema.Limit) -> bool:
    if value is None:
        return False
    above = limit.min is None or value >= limit.min
    below = limit.max is None or value <= limit.max
    return above and below
