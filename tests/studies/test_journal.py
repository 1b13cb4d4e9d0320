"""Journals: what a kill, a full disk or two workers leave in them is read as what it is."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import made_up
import pytest

from equipoise.studies.journal import Journal, read_journals
from equipoise.studies.plan import Plan

RUNS = list(Plan(made_up.study()).first())


def test_what_is_noted_is_read_back(tmp_path: Path) -> None:
    mine, other = Journal(tmp_path), Journal(tmp_path)
    mine.begin("a/0/0/0/0")
    result = made_up.result(RUNS[0], 0.01)
    mine.end(result)
    other.begin("b/0/0/0/0")
    noted = read_journals(tmp_path)
    assert noted.results == {result["id"]: result}
    assert noted.broken == Counter({"a/0/0/0/0": 1, "b/0/0/0/0": 1})
    other.forgive(Counter({"b/0/0/0/0": 1}))
    assert "b/0/0/0/0" not in read_journals(tmp_path).broken


def test_a_torn_line_is_a_run_that_was_begun(tmp_path: Path) -> None:
    journal = Journal(tmp_path)
    result = made_up.result(RUNS[0], 0.01)
    journal.begin(result["id"])
    journal.end(result)
    whole = journal.path.read_bytes()
    for cut in (2, 20, len(whole) // 3):  # the last character is the end of the line
        journal.path.write_bytes(whole[:-cut])
        noted = read_journals(tmp_path)
        assert not noted.results
        assert noted.broken[result["id"]] == 1


def test_a_run_that_ended_twice_is_found(tmp_path: Path) -> None:
    for _ in range(2):
        Journal(tmp_path).end(made_up.result(RUNS[0], 0.01))
    assert read_journals(tmp_path).repeated == [str(RUNS[0].id)]


def test_nothing_is_written_behind_a_line_that_a_full_disk_tore(tmp_path: Path) -> None:
    if not Path("/dev/full").exists():
        pytest.skip("no /dev/full here")
    journal = Journal(tmp_path)
    torn = journal.path
    torn.symlink_to("/dev/full")
    with pytest.raises(OSError, match="No space left"):
        journal.begin("a/0/0/0/0")
    torn.unlink()
    torn.write_text('{"beg')
    journal.begin("b/0/0/0/0")
    assert journal.path != torn
    assert read_journals(tmp_path).broken == Counter({"b/0/0/0/0": 1})
