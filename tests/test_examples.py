"""The examples run, and show what their first lines promise."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

FOLDER = Path(__file__).parents[1] / "examples"
LONGEST = 80  # lines that can be read in one sitting


@pytest.fixture
def example(tmp_path, monkeypatch):
    """Return a function that loads an example by its number, in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def load(number: int):
        (path,) = FOLDER.glob(f"{number:02d}_*.py")
        spec = importlib.util.spec_from_file_location(path.stem, path)
        module = importlib.util.module_from_spec(spec)
        monkeypatch.setitem(sys.modules, path.stem, module)
        spec.loader.exec_module(module)
        return module

    return load


def test_they_are_numbered_and_short():
    paths = sorted(FOLDER.glob("*.py"))
    assert [path.name[:3] for path in paths] == [f"{k + 1:02d}_" for k in range(len(paths))]
    for path in paths:
        assert len(path.read_text(encoding="utf-8").splitlines()) <= LONGEST, path.name


def test_every_example_has_a_test_here():
    text = Path(__file__).read_text(encoding="utf-8")
    for path in FOLDER.glob("*.py"):
        assert f"example({int(path.name[:2])})" in text, path.name


def test_strict_priorities(example, capsys):
    """The left hand gives way; what stands above it does not."""
    step, errors = example(1).main()
    assert np.linalg.norm(errors["right_palm"][:3]) < 0.005
    assert np.linalg.norm(errors["left_palm"][:3]) > 0.02
    assert max(step.solution.slack[:3]) < 1e-9
    assert step.solution.certificate(step.hierarchy).holds()
    assert "left_palm" in capsys.readouterr().out


def test_a_force_on_a_wall(example):
    force, posture = example(2).main()
    assert force == pytest.approx(20.0, abs=0.01)
    assert posture < 1e-5


def test_a_run_and_a_picture(example):
    path = example(3).main("here", "duration=0.05")
    assert path.read_bytes().startswith(b"\x89PNG")


def test_a_ceiling(example):
    top, ceiling, target = example(4).main()
    assert target > ceiling + 0.05
    assert ceiling - 0.001 < top < ceiling + 1e-5


def test_a_biped(example):
    run = example(5).main("biped")
    values = {name: row["value"] for name, row in run.summary["metrics"].items()}
    assert run.complete
    assert values["posture_error"] < 1e-3
    assert values["reaction_pressure"] > 0.0
    assert run["q"][:, 2].min() < 0.45 < run["q"][0, 2]


def test_solvers_are_told_apart(example):
    outcomes = example(6).main(0.1, 20)
    assert max(outcomes["active_set"].excess) < 1e-8
    assert outcomes["cascade"].holds == len(outcomes["cascade"].excess) == 5
    assert outcomes["daqp"].holds < 5
