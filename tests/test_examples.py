"""The examples run, and show what their first lines promise."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

from equipoise.robots import named_robots

FOLDER = Path(__file__).parents[1] / "examples"
LONGEST = 80  # lines that can be read in one sitting


@pytest.fixture
def example(tmp_path, monkeypatch):
    """Return a function that loads an example by its number or name, in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def load(which: int | str):
        pattern = f"{which:02d}_*.py" if isinstance(which, int) else f"{which}.py"
        (path,) = FOLDER.glob(pattern)
        spec = importlib.util.spec_from_file_location(path.stem, path)
        module = importlib.util.module_from_spec(spec)
        monkeypatch.setitem(sys.modules, path.stem, module)
        spec.loader.exec_module(module)
        return module

    return load


def test_they_are_numbered_or_named_and_short():
    """Those that are numbered build on one another; the others stand for themselves."""
    paths = sorted(FOLDER.glob("*.py"))
    numbered = [path.name[:3] for path in paths if path.name[0].isdigit()]
    assert numbered == [f"{k + 1:02d}_" for k in range(len(numbered))]
    for path in paths:
        assert len(path.read_text(encoding="utf-8").splitlines()) <= LONGEST, path.name


def test_every_example_has_a_test_here():
    text = Path(__file__).read_text(encoding="utf-8")
    for path in FOLDER.glob("*.py"):
        which = str(int(path.name[:2])) if path.name[0].isdigit() else f'"{path.stem}"'
        assert f"example({which})" in text, path.name


def test_strict_priorities(example, capsys):
    """The left hand gives way; what stands above it does not."""
    step, errors = example(1).main()
    assert np.linalg.norm(errors["right_palm"][:3]) < 0.005
    assert np.linalg.norm(errors["left_palm"][:3]) > 0.02
    assert max(step.solution.slack[:3]) < 1e-9
    # the stretched arm leaves the posture a direction that the hand blocks to 1e-10: hierarchy.md
    above_posture = step.solution.certificate(step.hierarchy).levels[:4]
    assert all(level.excess <= 1e-6 * level.scale for level in above_posture)
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


def lines_of_ours(path: Path) -> int:
    """Return how many statements stand between the marks "# -- Equipoise" and "# --"."""
    ours, count = False, 0
    for line in path.read_text(encoding="utf-8").splitlines():
        if line.strip().startswith("# --"):
            ours = "Equipoise" in line
        elif ours and line.strip():
            count += 1
    return count


def test_a_loop_that_is_plain_mujoco(example, capsys):
    """It stands, presses and bears a push, with at most twenty lines that are not the user's."""
    pytest.importorskip("mujoco")
    if missing := named_robots()["g1"].missing:
        pytest.skip(f"g1 is not installed: {missing}")
    assert example("own_mujoco_loop").main()
    assert "sag" in capsys.readouterr().out
    assert lines_of_ours(FOLDER / "own_mujoco_loop.py") <= 20 - 3  # and three imports


def test_a_target_that_moves(example):
    assert example("follow_target").main()


def needs_robots_and_mujoco() -> None:
    pytest.importorskip("mujoco")
    if missing := named_robots()["baxter"].missing:
        pytest.skip(f"example-robot-data is not installed: {missing}")


def test_a_fixed_arm_slides_along_a_table(example):
    needs_robots_and_mujoco()
    assert example("arm_force").main(4.0)


def test_a_quadruped_follows_a_circle(example):
    needs_robots_and_mujoco()
    assert example("quadruped").main()
