"""What the command line shows while it works."""

from __future__ import annotations

import io

import pytest
from rich.console import Console

from equipoise import console
from equipoise.console import Progress


@pytest.fixture
def screen(monkeypatch):
    """A console that writes into memory."""
    written = io.StringIO()
    monkeypatch.setattr(console, "_console", Console(file=written, width=120))
    return written


def lines(screen: io.StringIO) -> list[str]:
    return [line.rstrip() for line in screen.getvalue().splitlines() if line.strip()]


def test_stages_are_done_when_the_next_begins(screen):
    with Progress() as progress:
        progress("first", 0.5)
        progress("second", 0.0)
        progress("second", 1.0)
    first, second = lines(screen)
    assert first.startswith("first")
    assert second.startswith("second")
    assert all("100 %" in line for line in (first, second))


def test_work_without_a_share_does_not_end_the_stage_it_comes_in_between(screen):
    progress = Progress()
    progress("posture", 0.25)
    progress("compiling", None)
    progress.rest(finished=False)
    posture, compiling = lines(screen)
    assert "25 %" in posture
    assert "%" not in compiling


def test_what_is_printed_after_a_rest_stands_between_the_bars(screen):
    with Progress() as progress:
        progress("measuring", 0.0)
        progress.rest()
        console._console.print("the table")
        progress("drawing", 0.0)
    assert [line.split()[0] for line in lines(screen)] == ["measuring", "the", "drawing"]


def test_nothing_is_shown_of_what_never_began(screen):
    with Progress() as progress:
        progress.rest()
    assert screen.getvalue() == ""
