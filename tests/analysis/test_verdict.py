"""A run is met only if nothing impossible happened, whatever its file asks for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pytest

from equipoise import read_scenario, run_scenario
from equipoise.analysis.metrics.always import ALWAYS, CLAMPED_MOST
from equipoise.analysis.metrics.clearance import pushed_pairs, seen_by
from equipoise.analysis.metrics.registry import METRICS
from equipoise.analysis.metrics.verdict import impossible, judge, passed
from equipoise.analysis.run_context import RunContext
from equipoise.collision.distances import DistanceEvaluator
from equipoise.errors import ScenarioError
from equipoise.runlog import Run
from equipoise.scenarios.schema import AcceptanceSpec, Limit

TICK = 120  # at which something impossible is written into a log
Spoil = Callable[[dict[str, np.ndarray], RunContext], None]


def short_run(name: str, folder: Path) -> RunContext:
    """Return half a second of a shipped scenario that asks for nothing itself."""
    overrides = ["duration=0.5", "acceptance={limits: {}}", "control.start=standing"]
    return RunContext.of(run_scenario(name, out=folder, overrides=overrides, figures=False))


@pytest.fixture(scope="module")
def pressed(tmp_path_factory: pytest.TempPathFactory) -> RunContext:
    return short_run("press", tmp_path_factory.mktemp("verdict") / "press")


@pytest.fixture(scope="module")
def held(tmp_path_factory: pytest.TempPathFactory) -> RunContext:
    return short_run("tray", tmp_path_factory.mktemp("verdict") / "tray")


def spoilt(context: RunContext, spoil: Spoil) -> RunContext:
    """Return the run with something else in its log."""
    arrays = {name: array.copy() for name, array in context.run.arrays.items()}
    spoil(arrays, context)
    run: Run = replace(context.run, arrays=MappingProxyType(arrays))
    return RunContext(run, context.scenario, context.setup)


def asking(context: RunContext, **limits: Limit) -> RunContext:
    """Return the run judged by other limits of its file."""
    acceptance = AcceptanceSpec(after=0.0, limits=dict(limits))
    scenario = context.scenario.model_copy(update={"acceptance": acceptance})
    return RunContext(context.run, scenario, context.setup)


def write(channel: str, column: int, value: float) -> Spoil:
    """Write a value at one tick."""

    def spoil(arrays: dict[str, np.ndarray], context: RunContext) -> None:
        arrays[channel][TICK, column] = value

    return spoil


def clamp(every: int, seconds: float) -> Spoil:
    """Clamp a torque on every so-many-th tick for a while."""

    def spoil(arrays: dict[str, np.ndarray], context: RunContext) -> None:
        arrays["status"][TICK : TICK + round(seconds / 0.001) : every, 0] = 1.0

    return spoil


def shift(metres: float) -> Spoil:
    """Move the robot towards the wall for a moment."""

    def spoil(arrays: dict[str, np.ndarray], context: RunContext) -> None:
        arrays["q"][TICK : TICK + 20, 1] += metres

    return spoil


def cross_legs(arrays: dict[str, np.ndarray], context: RunContext) -> None:
    robot = context.setup.robot
    for joint, angle in (("LLEG_JOINT1", -0.3), ("RLEG_JOINT1", 0.3)):
        arrays["q"][TICK : TICK + 20, 7 + robot.joint_index(joint)] += angle


def past_stop(arrays: dict[str, np.ndarray], context: RunContext) -> None:
    arrays["q"][TICK, 7 + 3] = context.setup.robot.q_max[3] + 0.01


def pull_palms(arrays: dict[str, np.ndarray], context: RunContext) -> None:
    arrays["lam/grasp"][TICK, 2] = -1.0


SPOILT: dict[str, tuple[Spoil, str]] = {
    "mode_worst": (write("mode", 0, 2.0), "switched the law off"),
    "finite": (write("tau", 5, np.nan), "infinite or undefined"),
    "velocity_share": (write("v", 10, 1e3), "faster than it can"),
    "joint_margin": (past_stop, "past its stop"),
    "reaction_normal": (write("margin/right_sole", 0, -0.1), "a floor cannot pull"),
    "reaction_friction": (write("margin/right_sole", 1, -0.1), "slipped"),
    "reaction_pressure": (write("margin/right_sole", 2, -np.inf), "tipped over"),
    "reaction_yaw": (write("margin/right_sole", 3, np.nan), "turned on the floor"),
    "surface_normal": (write("lam/press", 0, -0.1), "a surface cannot pull"),
    "clamped_longest": (clamp(1, CLAMPED_MOST + 0.02), "at its limit"),
    "clearance": (cross_legs, "inside one another"),
    "touch_depth": (shift(-0.02), "inside of what it only touches"),
}


def test_a_run_in_which_nothing_happened_is_met(pressed: RunContext, held: RunContext) -> None:
    for context in (pressed, held):
        rows = judge(context)
        assert passed(rows), impossible(rows)
        assert {name for name, row in rows.items() if "wanted" in row} == set(ALWAYS) & set(rows)


def test_every_default_is_a_metric_and_is_spoilt_here() -> None:
    assert set(ALWAYS) <= set(METRICS)
    elsewhere = {"completed", "grasp_squeeze", "waypoint_miss"}
    assert set(SPOILT) | elsewhere == set(ALWAYS)


@pytest.mark.parametrize("name", SPOILT)
def test_what_cannot_be_is_found_and_said(name: str, pressed: RunContext) -> None:
    spoil, words = SPOILT[name]
    rows = judge(spoilt(pressed, spoil))
    assert not passed(rows)
    assert rows[name]["passed"] is False
    since = rows[name]["since"]
    late = CLAMPED_MOST if name == "clamped_longest" else 0.0  # it counts once it lasts
    assert since == pytest.approx(TICK * 0.001 + late, abs=0.0021 if late else 1e-9)
    sentence = next(s for s in impossible(rows) if words in s)
    assert f"first at t = {since:.3f} s" in sentence
    if name.startswith("reaction"):
        assert "(right_sole)" in sentence


def test_palms_that_pull_are_found(held: RunContext) -> None:
    rows = judge(spoilt(held, pull_palms))
    assert rows["grasp_squeeze"]["passed"] is False
    assert any("palms cannot pull" in s and "(grasp)" in s for s in impossible(rows))


def test_a_run_that_ended_early_is_not_met(pressed: RunContext) -> None:
    run = pressed.run
    arrays = {name: array[:300] for name, array in run.arrays.items()}
    cut = replace(run, t=run.t[:300], arrays=MappingProxyType(arrays))
    rows = judge(RunContext(cut, pressed.scenario, pressed.setup))
    assert not passed(rows)
    assert "did not reach its end" in impossible(rows)[0]


def test_a_torque_that_flips_between_its_limits_is_clamped_all_the_while(
    pressed: RunContext,
) -> None:
    assert not passed(judge(spoilt(pressed, clamp(5, 0.2))))
    assert passed(judge(spoilt(pressed, clamp(1, CLAMPED_MOST - 0.02))))
    assert passed(judge(spoilt(pressed, clamp(15, 0.3))))  # with rests in between


def test_a_file_loosens_by_name_and_the_table_says_so(pressed: RunContext) -> None:
    pulled = spoilt(pressed, write("margin/right_sole", 0, -3.0))
    rows = judge(asking(pulled, reaction_normal=Limit(min=-5.0)))
    assert passed(rows)
    assert rows["reaction_normal"]["wanted"] == {"min": -5.0}
    assert rows["reaction_normal"]["loosened"] == {"min": 0.0}
    assert impossible(rows) == []


def test_what_a_file_leaves_open_stays_as_it_always_is(pressed: RunContext) -> None:
    """Another side of the same metric, a stricter bound, another metric: nothing is loosened."""
    pulled = spoilt(pressed, write("margin/right_sole", 0, -3.0))
    for limits in (
        {"reaction_normal": Limit(max=1e4)},
        {"reaction_normal": Limit(min=1.0)},
        {"torque_share": Limit(max=1.0)},
    ):
        rows = judge(asking(pulled, **limits))
        assert not passed(rows)
        assert not any("loosened" in row for row in rows.values())


def test_a_pushed_object_is_looked_at_where_it_is(tmp_path: Path) -> None:
    """The robot as the object sees it is as far from it as the object from the robot."""
    run = run_scenario("telephone", out=tmp_path / "run", overrides=["duration=0.1"], figures=False)
    setup = RunContext.of(run).setup
    arrays = {name: array.copy() for name, array in run.arrays.items()}
    arrays["slider/telephone"][50:, 0] = 0.30
    run = replace(run, arrays=MappingProxyType(arrays))
    pairs = pushed_pairs(setup, run)["telephone"]
    assert not any(pair.first == "RARM_LINK5" for pair in pairs)  # the hand that pushes it
    assert any(pair.first == "LARM_LINK5" for pair in pairs)
    seen = DistanceEvaluator(setup.scene, pairs)
    moved = DistanceEvaluator(setup.scene_with({"telephone": 0.30}), pairs)
    q = seen_by(setup, run, "telephone")[60]
    there = seen.at(setup.robot.at(q)).copy()
    assert there == pytest.approx(moved.at(setup.robot.at(run["q"][60])), abs=1e-9)
    assert np.abs(there - seen.at(setup.robot.at(run["q"][60]))).max() > 0.05


@pytest.mark.parametrize("robot", ["hrp2", "romeo"])
def test_a_hand_that_is_sent_out_of_reach_does_not_end_met(robot: str, tmp_path: Path) -> None:
    if robot != "hrp2":
        from equipoise.robots import named_robots

        if named_robots()[robot].missing:
            pytest.skip(f"{robot} is not installed")
    waypoints = "{t: 0.2, xyz: [0.3, -0.3, 0.9]}, {t: 1.2, xyz: [2.2, -0.3, 1.0]}"
    away = f"tasks.right_hand.waypoints=[{waypoints}]"
    run = run_scenario(
        "press",
        out=tmp_path / "run",
        robot=robot if robot != "hrp2" else None,
        overrides=["duration=2.0", "acceptance={limits: {torque_share: {max: 1.0}}}", away],
        figures=False,
    )
    assert run.summary["passed"] is False
    assert run["mode"].max() == 0.0
    assert any("as far as it could" in fault for fault in run.summary["impossible"])
    assert any("cannot reach its waypoint" in told for told in run.summary["changes"])
    assert run.summary["metrics"]["waypoint_miss"]["value"] > 0.5


def test_the_schema_takes_no_limit_without_a_side() -> None:
    with pytest.raises(ScenarioError, match="give max or min"):
        read_scenario("press", ["acceptance.limits.clearance={}"])


def test_the_documentation_has_every_default() -> None:
    page = (Path(__file__).parents[2] / "docs" / "scenarios.md").read_text(encoding="utf-8")
    table = page.partition("<!-- always")[2].partition("These are defaults")[0]
    named = {line.split("`")[1]: line for line in table.splitlines() if line.startswith("| `")}
    assert set(named) == set(ALWAYS)
    for name, possible in ALWAYS.items():
        assert possible.fault in named[name]
        bound = possible.limit.max if possible.limit.min is None else possible.limit.min
        scale = {"m": 1e3, "rad": 1e3}.get(METRICS[name].unit, 1.0)
        assert f"{bound * scale:g}" in named[name].split("|")[2]
