"""Scenarios on an arm whose base is fixed: both engines, lost sensors, what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from arms import write_arm
from equipoise.analysis.figures.balance import balance_figure
from equipoise.analysis.run_context import RunContext
from equipoise.api import run_scenario
from equipoise.errors import ScenarioError
from equipoise.scenarios.read import parse_scenario
from equipoise.simulation.build.setup import build_setup

REACH = """
name: reach
robot: {robot}
duration: {duration}
physics: {{engine: {engine}}}
contacts: {contacts}
tasks:
  limits: {{kind: joint_limits, priority: 1}}
  hand:
    kind: frame_path
    frame: hand
    priority: 2
    waypoints:
      - {{t: 0.0, xyz: [0.82, 0.0, 0.34], rpy: [0.0, 2.2, 0.0]}}
      - {{t: 1.0, xyz: [0.72, 0.15, 0.44], rpy: [0.0, 2.3, 0.1]}}
  posture: {{kind: posture, priority: 3}}
control: {{start: standing}}
faults: {faults}
"""


def reach(
    folder: Path, engine: str = "rigid", *, contacts: str = "{}", faults: str = "{}",
    duration: float = 1.6,
) -> Path:  # fmt: skip
    path = folder / "reach.yaml"
    robot = write_arm(folder, "fixed")
    text = REACH.format(
        robot=robot, engine=engine, contacts=contacts, faults=faults, duration=duration
    )
    path.write_text(text)
    return path


def run(path: Path) -> Any:
    return run_scenario(str(path), out=path.with_name("run"), figures=False)


@pytest.mark.parametrize(("engine", "near"), [("rigid", 1e-4), ("mujoco", 5e-4)])
def test_an_arm_reaches(tmp_path: Path, engine: str, near: float) -> None:
    if engine == "mujoco":
        pytest.importorskip("mujoco")
    finished = run(reach(tmp_path, engine))
    values = {name: row["value"] for name, row in finished.metrics.items()}
    assert values["path_error"] < near
    assert values["completed"] == 1.0
    assert values["mode_worst"] == 0.0
    assert not {"base_error", "com_margin"} & set(values)  # there is no base to stray or to fall
    assert finished["q"].shape[1] == finished["v"].shape[1] == finished["tau"].shape[1] == 6
    assert finished.channels["q"].labels[0] == "joint1"
    context = RunContext.of(finished)
    assert context.joint_names == tuple(f"joint{k}" for k in range(1, 7))
    assert balance_figure(context) is None


def test_it_starts_without_a_step_of_torque(tmp_path: Path) -> None:
    """Standing on a fixed base needs gravity's torque at once, which `stand` gives."""
    torques = run(reach(tmp_path, duration=0.2))["tau"]
    assert np.abs(torques[0]).max() > 10.0
    assert np.abs(np.diff(torques, axis=0)).max() < 0.5


@pytest.mark.parametrize("sensor", ["joint3", "base"])
def test_a_lost_sensor_is_borne(tmp_path: Path, sensor: str) -> None:
    """An arm that lost a joint holds and comes back; a fixed base has no sensor to lose."""
    faults = f"{{silences: [{{sensor: {sensor}, start: 0.4, end: 0.6}}]}}"
    finished = run(reach(tmp_path, faults=faults, duration=2.0))
    modes = set(finished["mode"][:, 0])
    assert modes == ({0.0} if sensor == "base" else {0.0, 1.0, 2.0})
    assert finished["mode"][-1, 0] == 0.0
    assert np.isfinite(finished["tau"]).all()
    assert finished.metrics["posture_error"]["value"] < 0.5


def test_soles_and_polygons_are_refused(tmp_path: Path) -> None:
    path = reach(tmp_path)
    yaml = path.with_name("arm_fixed.yaml")
    sole = "soles: [{name: foot, frame: link0, x_min: -0.1, x_max: 0.1, y_min: -0.1, y_max: 0.1}]\n"
    yaml.write_text(yaml.read_text() + sole)
    text = reach(tmp_path / ".", contacts="{foot: {kind: sole, sole: foot}}").read_text()
    yaml.write_text(yaml.read_text() + sole)
    with pytest.raises(ScenarioError, match=r"contacts.foot.*needs no sole"):
        build_setup(parse_scenario(text))


def test_a_floating_arm_without_soles_is_told_of_fixed_bases(tmp_path: Path) -> None:
    path = reach(tmp_path)
    text = path.read_text().replace("arm_fixed", "arm_floating")
    write_arm(tmp_path, "floating")
    with pytest.raises(ScenarioError, match="base: fixed"):
        build_setup(parse_scenario(text))
