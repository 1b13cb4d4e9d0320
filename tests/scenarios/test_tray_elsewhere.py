"""The tray on robots that it was not made for: it begins well, with what its file says of each."""

from __future__ import annotations

from pathlib import Path

import pytest

from equipoise import run_scenario
from equipoise.robots import named_robots
from helpers import HUMANOIDS

pytestmark = pytest.mark.slow
ROBOTS = named_robots()
SHORT = ["duration=0.7", "acceptance.after=0.4"]


@pytest.mark.parametrize("name", sorted(set(HUMANOIDS) - {"hrp2"}))
def test_the_tray_is_held_under_the_desk(name: str, tmp_path: Path) -> None:
    if ROBOTS[name].missing:
        pytest.skip(f"{name} is not installed: {ROBOTS[name].missing}")
    run = run_scenario("tray", out=tmp_path / "run", robot=name, overrides=SHORT, figures=False)
    missed = {n: r for n, r in run.summary["metrics"].items() if not r.get("passed", True)}
    assert not missed
