"""A comparison on the screen and in files: HTML, LaTeX, figures, one page as PDF."""

from __future__ import annotations

import base64
import io
import json
from collections.abc import Callable
from html import escape
from pathlib import Path

from equipoise.analysis.figures.style import save
from equipoise.errors import NameNotFoundError, RunLogError
from equipoise.studies.compare.figures.make import figure_of, panels
from equipoise.studies.compare.paper import paper_page
from equipoise.studies.compare.tables import all_tables, as_html, as_latex, as_text
from equipoise.studies.compare.units import bound_text
from equipoise.studies.folder import PROVENANCE, write_whole
from equipoise.studies.results import Results, load_results

STYLE = """body{font:15px/1.5 sans-serif;color:#222;max-width:60em;margin:2em auto;padding:0 1em}
table{border-collapse:collapse;margin:.6em 0}td,th{padding:.25em .8em;text-align:right;
border-bottom:1px solid #ddd}td:first-child,th:first-child{text-align:left}
img{max-width:100%;margin:.6em 0}.soft{color:#6b6b6b;font-size:90%}pre{font-size:85%;
overflow-x:auto;background:#f6f6f6;padding:.8em}@media print{h2,img,table{break-inside:avoid}}"""


def load(place: Path, baseline: str | None) -> tuple[Results, str]:
    """Return results and the controller others are compared with: the first one by default.

    Raises: `RunLogError`, `NameNotFoundError`.
    """
    results = load_results(place)
    if baseline is not None and baseline not in results.controllers:
        raise NameNotFoundError("controller", baseline, results.controllers)
    return results, baseline or results.controllers[0]


def print_comparison(place: Path, say: Callable[[str], None], baseline: str | None = None) -> None:
    """Print the tables of a study."""
    for table in all_tables(*load(place, baseline)):
        say(as_text(table) + "\n")


def write_page(place: Path, to: Path | None = None, baseline: str | None = None) -> Path:
    """Write one HTML file with all tables and figures, which needs no network; return its path."""
    results, first = load(place, baseline)
    study = results.study
    title = study.title or study.name
    parts = [f"<h1>{escape(title)}</h1>", f"<p>{escape(setting(results))}</p>"]
    parts += [as_html(table) for table in all_tables(results, first)]
    for panel in panels(results, first):
        stream = io.BytesIO()
        figure_of(panel).savefig(stream, format="png", dpi=130)
        picture = base64.b64encode(stream.getvalue()).decode()
        parts.append(f'<img alt="{escape(panel.name)}" src="data:image/png;base64,{picture}">')
    told = (place / PROVENANCE).read_text(encoding="utf-8")
    spec = json.dumps(study.model_dump(mode="json", exclude_none=True), indent=1)
    parts += [f"<h2>Where it comes from</h2><pre>{escape(told)}</pre>"]
    parts += [f"<details><summary>The study</summary><pre>{escape(spec)}</pre></details>"]
    page = (
        f"<!doctype html><html lang=en><meta charset=utf-8><title>{escape(title)}</title>"
        f"<style>{STYLE}</style><body>{''.join(parts)}</body></html>\n"
    )
    return _written(to or place / "report.html", page)


def write_latex(place: Path, to: Path, baseline: str | None = None) -> Path:
    """Write the tables as LaTeX; return the path."""
    tables = all_tables(*load(place, baseline))
    return _written(to, "\n\n".join(map(as_latex, tables)) + "\n")


def write_figures(place: Path, to: Path, baseline: str | None = None) -> list[Path]:
    """Write each figure as PDF and PNG; return their paths."""
    results, first = load(place, baseline)
    to.mkdir(parents=True, exist_ok=True)
    paths = []
    for panel in panels(results, first):
        figure = figure_of(panel)
        paths += [save(figure, to / f"{panel.name}.{kind}") for kind in ("pdf", "png")]
    return paths


def write_pdf(place: Path, to: Path, baseline: str | None = None) -> Path:
    """Write the page that one could attach to a submission; return its path."""
    results, first = load(place, baseline)
    stream = io.BytesIO()
    figure = paper_page(results, first, setting(results))
    figure.savefig(stream, format="pdf", metadata={"CreationDate": None})
    return _written(to, stream.getvalue())


def setting(results: Results) -> str:
    """Return in sentences what was run."""
    study = results.study
    robot = study.robot or "the scenario's robot"
    kept = ", ".join(bound_text(name, limit) for name, limit in study.good.items())
    return (
        f"Scenario {study.scenario} on {robot}, {len(results)} runs, "
        f"{study.seeds} seed{'s' * (study.seeds > 1)} a point; noise and faults are the same for "
        f"all controllers. Good: it stands{', ' if kept else ''}{kept}."
    )


def _written(path: Path, content: str | bytes) -> Path:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, content)
    except OSError as error:
        raise RunLogError(f"Cannot write {path}: {error.strerror}.") from error
    return path
