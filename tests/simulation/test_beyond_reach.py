"""A hand that is sent beyond its reach: the arm stretches, the robot stands, and it is said."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import numpy as np
import pytest

from equipoise.robots import named_robots
from equipoise.scenarios import read_scenario
from equipoise.scenarios.read import parse_scenario
from equipoise.simulation.build import assemble as assembling
from equipoise.simulation.build.assemble import Prepared, assemble_controls

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def sweep():
    sys.path.insert(0, str(ROOT / "benchmarks"))
    yield importlib.import_module("sweep_reach")
    sys.path.remove(str(ROOT / "benchmarks"))


@pytest.mark.parametrize(
    ("robot", "engine", "direction"),
    [
        ("hrp2", "rigid", "up"),
        pytest.param("hrp2", "mujoco", "behind", marks=pytest.mark.slow),
        pytest.param("romeo", "rigid", "forward", marks=pytest.mark.slow),
    ],
)
def test_it_waits_standing_and_the_verdict_is_honest(sweep, tmp_path, robot, engine, direction):
    if named_robots()[robot].missing:
        pytest.skip(f"{robot} is not installed")
    found = sweep.run_case(sweep.Case(robot, engine, direction, 0.5), tmp_path)
    assert found.wrong == ()
    assert found.miss > 0.3


def test_the_way_becomes_calm_and_slow_unless_the_file_decides(sweep):
    text = sweep.Case("hrp2", "rigid", "up", 0.5).text()
    controls = assemble_controls(parse_scenario(text))
    spec = controls.scenario.tasks["hand"]
    assert spec.calm
    assert (spec.speed, spec.acceleration) == (0.5, 0.7)
    assert [miss.number for miss in controls.misses] == [1]
    assert any("s instead of 1 s" in told for told in controls.told)
    assert "less where" in controls.advice.shape
    decided = text.replace("frame: right_palm", "frame: right_palm\n    calm: false")
    left = assemble_controls(parse_scenario(decided))
    assert left.scenario.tasks["hand"].speed is None
    assert left.misses


def test_what_is_within_reach_is_left_as_it_is():
    spec = read_scenario("press")
    controls = assemble_controls(spec)
    assert controls.scenario == spec
    assert controls.misses == ()
    assert controls.levels[2][1].reach is None


@pytest.mark.parametrize("robot", ["hrp2", "g1"])
def test_runs_that_share_their_start_look_out_once(sweep, robot, monkeypatch):
    """What a prepared run is given is what it would find: same scenario, levels and gains."""
    if named_robots()[robot].missing:
        pytest.skip(f"{robot} is not installed")
    scenario = parse_scenario(sweep.Case(robot, "rigid", "up", 0.5).text())
    first = assemble_controls(scenario)
    assert first.misses
    assert first.outlook.ahead
    monkeypatch.setattr(assembling, "missed_waypoints", None)
    monkeypatch.setattr(assembling, "look_ahead", None)
    again = assemble_controls(scenario, Prepared(first.setup.robot, first.q_start, first.outlook))
    assert again.scenario == first.scenario
    assert again.misses == first.misses
    assert np.array_equal(again.advice.K_d, first.advice.K_d)
