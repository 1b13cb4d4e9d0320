"""One self-contained HTML file about one or several runs, to be sent to a colleague."""

from __future__ import annotations

import base64
import hashlib
import json
import re
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Any

from equipoise.analysis.feet_phases import phases_sentence
from equipoise.analysis.metrics.verdict import judge, passed
from equipoise.analysis.report.modes import modes_sentence, status_sentence
from equipoise.analysis.report.replay_export import Blobs, export_replay
from equipoise.analysis.report.tables import metrics_table, properties
from equipoise.analysis.run_context import RunContext
from equipoise.errors import EquipoiseError, InputError, RunLogError
from equipoise.runlog import Run, load_run
from equipoise.runlog.folders import LOG_NAME

MOST_TICKS = 50_000  # of a longer run every so-many-th tick is read for the replay
_OWN_SECTIONS = {"impossible", "metrics", "scenario", "title", "passed", "versions"}


@dataclass(frozen=True)
class Exhibit:
    """A run as the report shows it; `replay` is None where the robot cannot be drawn."""

    run: Run
    path: Path
    title: str
    summary: Mapping[str, Any]
    figures: Mapping[str, bytes]
    replay: dict[str, Any] | None
    notes: list[str] = field(default_factory=list)


def make_report(
    runs: Sequence[Path | str], out: Path | str, *, told: Callable[[str], None] | None = None
) -> Path:
    """Write a report of these run folders into the file `out` and return its path.

    Figures that lie in a run's folder are taken from there, others are drawn. A run that broke
    off, or has no summary, is shown as far as it goes; `told` is given what is wrong with its log.
    Raises: `RunLogError` if a run cannot be read or the file not be written.
    """
    if not runs:
        raise InputError("a report needs at least one run", remedy="Give the folder of a run")
    blobs = Blobs()
    exhibits = [_exhibit(Path(path), blobs) for path in runs]
    for exhibit in exhibits:
        if told is not None and exhibit.run.note:
            told(exhibit.run.note)
    out = Path(out)
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        out.write_text(_page(exhibits, blobs), encoding="utf-8")
    except OSError as error:
        raise RunLogError(f"Cannot write {out}: {error.strerror}.") from error
    return out


def _exhibit(path: Path, blobs: Blobs) -> Exhibit:
    run, notes = _load(path), []
    if run.note:
        notes.append(run.note)
    context = RunContext.of(run)
    summary = dict(run.summary or {})
    replay = None
    if not context.known:
        notes.append("Its scenario can no longer be read: no replay.")
    elif context.drawable:
        replay = export_replay(run, context.scenario, context.setup, blobs)
    if not summary and context.known:
        summary = _judged(run, context, notes)
    notes += [f"Impossible: {fault}." for fault in summary.get("impossible") or ()]
    title = str(summary.get("title") or run.info.get("scenario") or run.folder.name)
    return Exhibit(run, path, title, summary, _figures(run, notes), replay, notes)


def _load(path: Path) -> Run:
    """Load the run, thinned if it is long."""
    bare = load_run(path, start=-1.0, stop=-1.0)
    ticks = 0.0
    if bare.summary is not None:
        ticks = float(bare.summary.get("simulated_s") or 0.0) * 1000.0
    stride = max(1, round(ticks / MOST_TICKS))
    return load_run(path, stride=stride)


def _judged(run: Run, context: RunContext, notes: list[str]) -> dict[str, Any]:
    """Return metrics computed from the log, for a run that left no summary."""
    notes.append("The run left no summary; the table was computed from what is in its log.")
    try:
        rows = judge(context)
    except (EquipoiseError, ValueError, KeyError):
        return {}
    judged: dict[str, Any] = {"metrics": rows, "versions": dict(run.info)}
    if any("passed" in row for row in rows.values()):
        judged["passed"] = run.complete and passed(rows)
    return judged


def _figures(run: Run, notes: list[str]) -> dict[str, bytes]:
    drawn = sorted((run.folder / "figures").glob("*.png"))
    if drawn:
        return {path.stem: path.read_bytes() for path in drawn}
    if not run.t.size:
        return {}
    from equipoise.analysis.figures.make import make_figures

    with tempfile.TemporaryDirectory() as folder:
        try:
            paths = make_figures(run, Path(folder))
        except EquipoiseError as error:
            notes.append(f"No figures: {error}")
            return {}
        return {path.stem: path.read_bytes() for path in paths}


def _page(exhibits: Sequence[Exhibit], blobs: Blobs) -> str:
    titles = list(dict.fromkeys(exhibit.title for exhibit in exhibits))
    subtitle = ", ".join(escape(_name(exhibit)) for exhibit in exhibits)
    times = [float(e.run.t[i]) for e in exhibits if e.replay is not None for i in (0, -1)]
    replays = {
        "first": min(times, default=0.0),
        "last": max(times, default=0.0),
        "runs": [exhibit.replay for exhibit in exhibits],
        "blobs": blobs.texts,
    }
    body = [
        _replays(exhibits),
        "<h2>Wanted and achieved</h2>",
        metrics_table([(_name(e), e.summary.get("metrics") or {}) for e in exhibits]),
        _figure_rows(exhibits),
        _abouts(exhibits),
    ]
    filled = {
        "title": escape("; ".join(titles)),
        "subtitle": subtitle,
        "style": _asset("style.css"),
        "body": "\n".join(body),
        "replays": json.dumps(replays).replace("<", "\\u003c"),
        "script": _asset("replay.js"),
    }
    pieces = re.split(r"\{\{(\w+)\}\}", _asset("page.html"))
    return "".join(filled[piece] if i % 2 else piece for i, piece in enumerate(pieces))


def _replays(exhibits: Sequence[Exhibit]) -> str:
    """Return picture, controls and notes, in this order: the first two fit on a screen."""
    cells, notes = [], []
    for i, exhibit in enumerate(exhibits):
        verdict = _verdict(exhibit)
        run = exhibit.run
        told = (*exhibit.notes, modes_sentence(run), status_sentence(run), phases_sentence(run))
        said = "".join(f'<p class="soft">{escape(note)}</p>' for note in told if note)
        notes.append(f"<section>{said}</section>")
        canvas = f'<canvas id="replay{i}"></canvas>' if exhibit.replay is not None else ""
        cells.append(f"<section><h3>{escape(_name(exhibit))} {verdict}</h3>{canvas}</section>")
    controls = (
        '<div class="controls"><button id="play">Play</button>'
        '<input id="time" type="range" aria-label="time"><output id="shown"></output></div>'
        '<p class="soft">Space plays, arrows step, dragging turns, the wheel zooms. Red: force of '
        "the floor on each sole, 1 m is 1000 N.</p>"
    )
    shown = controls if any(exhibit.replay is not None for exhibit in exhibits) else ""
    pictures = f'<h2>What was run</h2><div class="runs">{"".join(cells)}</div>{shown}'
    return f'{pictures}<div class="runs">{"".join(notes)}</div>'


def _verdict(exhibit: Exhibit) -> str:
    if "passed" not in exhibit.summary:
        return ""
    if exhibit.summary["passed"]:
        return '<span class="met">met</span>'
    return '<span class="missed">not met</span>'


def _figure_rows(exhibits: Sequence[Exhibit]) -> str:
    names = list(dict.fromkeys(name for exhibit in exhibits for name in exhibit.figures))
    rows = []
    for name in names:
        cells = []
        for exhibit in exhibits:
            picture = exhibit.figures.get(name)
            if picture is not None:
                text = base64.b64encode(picture).decode()
                label = escape(f"{name} of {_name(exhibit)}")
                cells.append(f'<img alt="{label}" src="data:image/png;base64,{text}">')
            else:
                cells.append("<div></div>")
        rows.append(f'<h3>{escape(name)}</h3><div class="runs">{"".join(cells)}</div>')
    return "<h2>Figures</h2>" + "".join(rows) if rows else ""


def _abouts(exhibits: Sequence[Exhibit]) -> str:
    cells = []
    for exhibit in exhibits:
        summary = exhibit.summary
        about = {k: v for k, v in summary.items() if k not in _OWN_SECTIONS}
        about["log"] = f"{LOG_NAME}, SHA-256 {_digest(exhibit)}"
        versions = dict(summary.get("versions") or exhibit.run.info)
        cells.append(
            f"<section><h3>{escape(_name(exhibit))}</h3>{properties(about)}<h3>Versions</h3>"
            f"{properties(versions)}<details><summary>Scenario, every default written out"
            f"</summary><pre>{escape(exhibit.run.scenario_text)}</pre></details></section>"
        )
    return f'<h2>Certificates, speed, versions</h2><div class="runs">{"".join(cells)}</div>'


def _digest(exhibit: Exhibit) -> str:
    log = exhibit.path / LOG_NAME if exhibit.path.is_dir() else exhibit.path
    try:
        with open(log, "rb") as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    except OSError:
        return "unknown"


def _name(exhibit: Exhibit) -> str:
    return exhibit.run.folder.resolve().name


def _asset(name: str) -> str:
    return files("equipoise.analysis.report").joinpath("files", name).read_text(encoding="utf-8")
