"""The tray scenario in closed loop: what the README promises, and that its inequalities matter."""

from __future__ import annotations

import math

import numpy as np
import pytest

from equipoise import run_scenario

pytestmark = pytest.mark.slow

TRANSIENT = "duration=1.2"


def metrics(run):
    return {name: row["value"] for name, row in run.summary["metrics"].items()}


def run_tray(folder, *overrides):
    return run_scenario("tray", out=folder, overrides=overrides, figures=False)


@pytest.fixture(scope="module")
def nominal(tmp_path_factory):
    return run_tray(tmp_path_factory.mktemp("tray") / "run")


def test_nominal_meets_its_acceptance(nominal):
    missed = {n: r for n, r in nominal.summary["metrics"].items() if not r.get("passed", True)}
    assert not missed
    assert nominal.summary["passed"]
    assert nominal.complete


def test_it_is_the_scenario_it_says_to_be(nominal):
    """Most of the tray starts under the desk and ends above it; the way leads around the edge."""
    from equipoise.scenarios import parse_scenario

    world = parse_scenario(nominal.scenario_text).world
    top = world.bodies["desk"].shapes[0]
    edge = top.at.xyz[0] - top.box[0] / 2
    under, over = top.at.xyz[2] - top.box[2] / 2, top.at.xyz[2] + top.box[2] / 2
    way = world.objects["tray"].waypoints
    half = world.objects["tray"].shapes[0].box[0] / 2

    def covered(waypoint):
        return (waypoint.xyz[0] + half - edge) / (2 * half)

    assert covered(way[0]) > 0.5
    assert way[0].xyz[2] < under
    assert covered(way[-1]) > 0.5
    assert way[-1].xyz[2] > over
    assert any(covered(w) <= 0 and w.xyz[2] < under for w in way)
    assert any(covered(w) <= 0 and w.xyz[2] > over for w in way)


def test_the_squeeze_is_fifteen_newtons(nominal):
    assert nominal["lam_ref/grasp"][-1] == pytest.approx([15.0])
    assert nominal["lam/grasp"][-1, 2] == pytest.approx(15.0, abs=0.1)


def test_the_same_command_twice_gives_the_same_bits(tmp_path):
    first = run_tray(tmp_path / "a", "duration=0.3")
    second = run_tray(tmp_path / "b", "duration=0.3")
    assert first.names == second.names
    for name in first.names:
        assert np.array_equal(first[name], second[name]), name


def test_an_unknown_five_kilograms_on_the_tray(tmp_path):
    values = metrics(
        run_tray(tmp_path / "run", "disturbances.payloads=[{mass: 5.0, object: tray}]")
    )
    assert values["completed"] == 1
    assert values["palm_position_worst"] <= 0.020
    assert values["palm_position_end"] <= 0.003
    assert values["torque_share"] <= 1.0


@pytest.mark.parametrize("scale", [0.7, 1.3])
def test_masses_that_are_thirty_percent_off(tmp_path, scale):
    values = metrics(run_tray(tmp_path / "run", f"disturbances.mass_scale={scale}"))
    assert values["completed"] == 1
    assert values["palm_position_worst"] <= 0.002


def test_without_avoidance_it_hits_the_desk(tmp_path, nominal):
    values = metrics(run_tray(tmp_path / "run", "tasks.obstacles.enabled=false", TRANSIENT))
    assert values["clearance"] < 0.0
    assert metrics(nominal)["clearance"] > 0.0


def test_without_the_com_task_it_leaves_the_polygon(tmp_path, nominal):
    values = metrics(run_tray(tmp_path / "run", "tasks.com.enabled=false", "duration=2.8"))
    assert values["com_margin"] < 0.0
    assert metrics(nominal)["com_margin"] > 0.01


def test_smaller_physics_steps_tell_the_same_story(tmp_path, nominal):
    """Control at 1 kHz held over four physics steps: errors of the same size."""
    values = metrics(run_tray(tmp_path / "run", "physics.substeps=4", TRANSIENT))
    assert values["palm_position_worst"] < 0.002
    assert math.isfinite(values["posture_error"])
