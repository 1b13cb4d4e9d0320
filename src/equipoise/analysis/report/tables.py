"""The tables of a report: metrics of runs side by side, and nested properties."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

_SHOWN = {"m": (1e3, "mm"), "rad": (1e3, "mrad")}
_LOOKS: dict[object, str] = {True: "number met", False: "number missed"}
_SIGNS = {"max": "≤", "min": "≥"}
Rows = Mapping[str, Mapping[str, Any]]


def metrics_table(runs: Sequence[tuple[str, Rows]]) -> str:
    """Return an HTML table: a metric a row; achieved and wanted of each run."""
    names = list(dict.fromkeys(name for _, rows in runs for name in rows))
    if not names:
        return '<p class="soft">No run has a summary.</p>'
    head = "".join(f'<th colspan="2">{escape(run)}</th>' for run, _ in runs)
    below = "<th>achieved</th><th>wanted</th>" * len(runs)
    body = []
    for name in names:
        doc = next(str(rows[name].get("doc", name)) for _, rows in runs if name in rows)
        cells = "".join(_cells(rows.get(name)) for _, rows in runs)
        body.append(f'<tr><td title="{escape(name)}">{escape(doc)}</td>{cells}</tr>')
    return (
        f'<div class="scroll"><table><tr><th></th>{head}</tr><tr><th></th>{below}</tr>'
        f"{''.join(body)}</table></div>"
    )


def quantity(value: Any, unit: str) -> str:
    """Return a number with its unit, as a person reads it."""
    if value is None:
        return "–"
    scale, shown = _SHOWN.get(unit, (1.0, unit))
    return f"{float(value) * scale:.4g} {shown}".rstrip()


def properties(values: Mapping[str, Any]) -> str:
    """Return nested names and values as an HTML list."""
    entries = "".join(
        f"<dt>{escape(str(key).replace('_', ' '))}</dt><dd>{_value(value)}</dd>"
        for key, value in values.items()
        if value not in (None, "", [], {})
    )
    return f"<dl>{entries}</dl>"


def _cells(row: Mapping[str, Any] | None) -> str:
    if row is None:
        return "<td></td><td></td>"
    unit = str(row.get("unit", ""))
    look = _LOOKS.get(row.get("passed"), "number")
    bounds = row.get("wanted") or {}
    wanted = ", ".join(f"{_SIGNS.get(k, k)} {quantity(bounds[k], unit)}" for k in bounds)
    always = row.get("loosened") or {}
    if always:
        usual = ", ".join(f"{_SIGNS.get(k, k)} {quantity(always[k], unit)}" for k in always)
        wanted += f" (loosened from {usual})"
    achieved = escape(quantity(row.get("value"), unit))
    return f'<td class="{look}">{achieved}</td><td>{escape(wanted)}</td>'


def _value(value: Any) -> str:
    if isinstance(value, Mapping):
        return properties(value)
    if isinstance(value, list | tuple):
        if all(isinstance(entry, int | float) for entry in value):
            return escape(", ".join(_plain(entry) for entry in value))
        return "<br>".join(_value(entry) for entry in value)
    return escape(_plain(value))


def _plain(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
