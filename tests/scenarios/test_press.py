"""The scenario `press` in closed loop on every named humanoid, without a line of code for any."""

from __future__ import annotations

from pathlib import Path

import pytest

from equipoise import run_scenario
from equipoise.robots import named_robots
from helpers import HUMANOIDS

pytestmark = pytest.mark.slow
ROBOTS = named_robots()


@pytest.mark.parametrize("name", HUMANOIDS)
def test_press_meets_its_acceptance(name: str, tmp_path: Path) -> None:
    if ROBOTS[name].missing:
        pytest.skip(f"{name} is not installed: {ROBOTS[name].missing}")
    run = run_scenario(
        "press", out=tmp_path / "run", robot=name, overrides=["duration=1.3"], figures=False
    )
    assert run.summary["robot"] == name
    assert not {n: r for n, r in run.summary["metrics"].items() if not r.get("passed", True)}
    assert run["lam/press"][-1, 0] == pytest.approx(20.0, rel=0.05)
