"""Run folders are distinct, the latest is found, and summaries come back as they were."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from equipoise.errors import InputError, RunLogError
from equipoise.runlog import latest_run, new_run_folder, read_summary, write_summary


def test_folders_of_the_same_second_differ(tmp_path: Path) -> None:
    folders = [new_run_folder(tmp_path / "runs", "reach wall/1") for _ in range(4)]
    assert len(set(folders)) == 4
    assert all(folder.is_dir() and folder.parent == tmp_path / "runs" for folder in folders)
    assert all(folder.name.startswith("reach-wall-1-") for folder in folders)
    assert latest_run(tmp_path / "runs").samefile(folders[-1])


def test_latest_survives_without_symbolic_links(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise OSError(1, "Operation not permitted")

    monkeypatch.setattr(Path, "symlink_to", refuse)
    folder = [new_run_folder(tmp_path, "reach") for _ in range(2)][-1]
    assert (tmp_path / "latest").is_file()
    assert latest_run(tmp_path) == folder


def test_latest_is_found_without_its_note(tmp_path: Path, write: Callable) -> None:
    """Copied runs have no note, or one that points nowhere: the newest log counts."""
    with pytest.raises(RunLogError, match="no run in"):
        latest_run(tmp_path)
    write(tmp_path / "b", 1)
    write(tmp_path / "a", 1)
    assert latest_run(tmp_path) == tmp_path / "a"
    (tmp_path / "latest").symlink_to("gone")
    assert latest_run(tmp_path) == tmp_path / "a"


def test_names_and_places_without_sense_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="letter or a digit"):
        new_run_folder(tmp_path, "../..")
    (tmp_path / "file").write_text("")
    with pytest.raises(RunLogError, match="Cannot make a run folder"):
        new_run_folder(tmp_path / "file", "reach")


NUMBERS = st.none() | st.booleans() | st.integers() | st.floats() | st.text(min_size=5)
VALUES = st.recursive(
    NUMBERS, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner)
)


@given(st.dictionaries(st.text(), VALUES, max_size=5))
@settings(max_examples=40, deadline=None)
def test_summaries_come_back(summary: dict) -> None:
    with tempfile.TemporaryDirectory() as place:
        write_summary(Path(place), summary)
        text = (Path(place) / "summary.json").read_text(encoding="utf-8")
        assert repr(read_summary(Path(place))) == repr(summary)
        assert len(list(Path(place).iterdir())) == 1
    json.loads(text, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))


def test_numpy_values_are_taken_and_others_refused(tmp_path: Path) -> None:
    write_summary(
        tmp_path, {"a": np.float64(0.1), "b": np.arange(3), "c": np.bool_(True), "d": Path("x")}
    )
    assert read_summary(tmp_path) == {"a": 0.1, "b": [0, 1, 2], "c": True, "d": "x"}
    with pytest.raises(InputError, match="cannot hold a set"):
        write_summary(tmp_path, {"a": {1}})
    assert read_summary(tmp_path)["a"] == 0.1


def test_summaries_that_cannot_be_read_or_written_are_named(tmp_path: Path) -> None:
    with pytest.raises(RunLogError, match="Cannot read"):
        read_summary(tmp_path)
    with pytest.raises(RunLogError, match="Cannot write"):
        write_summary(tmp_path / "gone", {})
    (tmp_path / "summary.json").write_text("[1]")
    with pytest.raises(RunLogError, match="should hold an object"):
        read_summary(tmp_path)
