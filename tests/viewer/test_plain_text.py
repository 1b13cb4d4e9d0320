"""Titles, names and notes of strangers show as they are written, nowhere as markup."""

from __future__ import annotations

import html
import io
import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from rich.console import Console

from equipoise import console
from equipoise.analysis.figures.style import new_figure, styled
from equipoise.errors import ScenarioError
from equipoise.scenarios import read_scenario
from equipoise.viewer.plain_text import in_markdown
from equipoise.viewer.replay import Replay

HOSTILE = (
    "<iframe srcdoc='<script>parent.document.title=1</script>'></iframe>",
    "<img src=x onerror=alert(1)>",
    "{window.alert(1)}",
    "[click](javascript:alert(1))",
    "![x](http://example.org/x.png)",
    "**bold** _it_ `code` ~~no~~ # head",
    "&lt;script&gt; &#60;b&#62; &amp;",
    "a\n\n# head\n- item\n> quote\n| a | b |",
    "$x_{$ costs \\$5 [red]",
    "<https://example.org> www.example.org",
    "é ° – ü",
)


@pytest.mark.parametrize("text", HOSTILE)
def test_nothing_that_begins_markup_is_left(text):
    shown = in_markdown(text)
    assert html.unescape(shown) == " ".join(text.split())
    left = shown.replace("&#", "").replace(";", "")
    assert not set(left) & set("<>{}[]()!*_`~#|\\$&'\"=+.:@-\n")


@pytest.mark.parametrize("text", HOSTILE)
def test_the_page_shows_title_note_and_folder_as_text(text):
    said = []
    run = SimpleNamespace(
        folder=Path("runs") / text.replace("/", "").replace("\n", ""),
        summary={"passed": True, "ended": text},
        note=text,
    )
    gui = SimpleNamespace(add_markdown=said.append)
    stub = SimpleNamespace(
        log=SimpleNamespace(run=run, note=text),
        server=SimpleNamespace(viser=SimpleNamespace(gui=gui)),
    )
    Replay._summary(stub, text)
    [page] = said
    for part in page.replace("**", "").replace("*", "").split("\n\n"):
        assert not set(part) & set("<>{}[]()!_`~|\\$")


@pytest.mark.parametrize("text", ["costs $5 or $x_{$", r"$\frac{", "[/red] $a$", "a_b^c"])
def test_figures_take_names_for_names(text):
    @styled
    def draw():
        figure = new_figure(3.0, 3.0, text)
        axes = figure.add_subplot()
        axes.plot([0.0, 1.0], label=text)
        axes.set_title(text)
        axes.set_ylabel(text)
        axes.legend()
        figure.canvas.draw()
        return np.asarray(figure.canvas.buffer_rgba())

    assert draw().min() < 250


@pytest.mark.parametrize("text", ["[/red]", "[bold]x[/bold]", "[link=file:///etc]y[/link]", "[a"])
def test_the_console_takes_titles_for_titles(monkeypatch, text):
    stream = io.StringIO()
    monkeypatch.setattr(console, "_console", Console(file=stream, width=200, highlight=False))
    summary = {
        "title": text,
        "scenario": "x",
        "robot": text,
        "metrics": {"m": {"doc": text, "value": 1.0, "unit": "m", "passed": True, "wanted": {}}},
        "timing": {
            "wall": 2.0,
            "first_wall": 0.0,
            "t_end": 1.0,
            "tick_us": [1.0],
            "physics_us": [1.0],
        },
        "ended": "stopped",
        "note": text,
        "passed": False,
    }
    console.print_summary(json.loads(json.dumps(summary)), Path(text))
    assert stream.getvalue().count(text) >= 4


@pytest.mark.parametrize("title", ['"\\e]0;x\\a"', '"a\\nb"', "x" * 300])
def test_a_title_is_one_printable_line(tmp_path, title):
    path = tmp_path / "mine.yaml"
    path.write_text(f"extends: press\ntitle: {title}\n", encoding="utf-8")
    with pytest.raises(ScenarioError, match="title"):
        read_scenario(str(path))
