"""What is short is what failed its user; explanation and viewer say the same word and number."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from equipoise import run_scenario
from equipoise.analysis.explain_run import explain_tick, rebuild_tick
from equipoise.hqp.explanation import AT_BOUND, LEFT_OVER, MET, SHORT
from equipoise.hqp.row_names import quantity
from equipoise.robots import get_robot
from equipoise.runlog import Run
from equipoise.scenarios.read import parse_scenario
from equipoise.simulation.build.fades import build_fades
from equipoise.simulation.build.levels import build_levels
from equipoise.simulation.build.setup import build_setup
from equipoise.tasks import JointLimitsTask, PostureTask
from equipoise.tasks.standing import standing_of

TIMES = (0.05, 0.4, 0.9, 1.3, 1.75, 2.15)


@pytest.fixture(scope="module")
def low(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """The tray pressed against the desk from below, on slow joints."""
    folder = tmp_path_factory.mktemp("standing") / "run"
    overrides = ["duration=2.2", "tasks.limits.velocity_share=0.06"]
    overrides += ["world.objects.tray.waypoints=[{t: 0.3, xyz: [0.52, 0, 0.69]}, "
                  "{t: 1.2, xyz: [0.52, 0, 0.72]}, {t: 2.2, xyz: [0.52, 0, 0.735]}]"]  # fmt: skip
    return run_scenario("tray", out=folder, overrides=overrides, figures=False)


@pytest.mark.parametrize("t", TIMES)
def test_explanation_and_viewer_say_the_same(low: Run, t: float) -> None:
    scenario = parse_scenario(low.scenario_text)
    setup = build_setup(scenario)
    levels, fades = build_levels(scenario, setup), build_fades(scenario)
    k = low.at(t)
    kin = setup.robot.at(low["q_ref"][k], low["v_ref"][k], float(low.t[k]))
    said = rebuild_tick(low.folder, t).explain()
    assert not fades
    for task in (task for level in levels for task in level):
        stands = standing_of(task, kin, low["v_ref"][k], float(low.t[k]))
        short = said.of(task.name)
        if stands.word == SHORT or (short is not None and short.standing == SHORT):
            assert short is not None
            assert stands.word == short.standing
            shown = [quantity(*amount) for amount in stands.amounts]
            assert shown == [quantity(*amount) for amount in short.amounts]
            assert f"{task.name} is {' and '.join(shown)} short" in str(said)


def test_something_is_short_and_something_is_left_over(low: Run) -> None:
    words = [
        {s.task: s.standing for s in rebuild_tick(low.folder, t).explain().shortfalls}
        for t in TIMES
    ]
    assert any(SHORT in one.values() for one in words)
    assert any(one.get("posture") == LEFT_OVER for one in words)
    assert all(one.get("posture", LEFT_OVER) == LEFT_OVER for one in words)


def test_a_run_in_which_all_is_met_says_so(tmp_path: Path) -> None:
    run = run_scenario("press", out=tmp_path / "run", overrides=["duration=0.4"], figures=False)
    told = "\n".join(explain_tick(run.folder, 0.3))
    assert "No task is short." in told
    assert "posture is left over" in told
    assert " short" not in told.replace("No task is short.", "")


def test_a_joint_at_its_speed_bound_is_at_its_bound() -> None:
    robot = get_robot("hrp2")
    q = robot.q_half_sitting
    kin, v = robot.at(q), np.zeros(robot.nv)
    limits = JointLimitsTask("limits", robot, velocity_share=0.5)
    assert standing_of(limits, kin, v, 0.0).word == MET
    v[robot.nv_base + 4] = 0.5 * robot.v_max[4]
    assert standing_of(limits, kin, v, 0.0).word == AT_BOUND
    v[robot.nv_base + 4] = 0.6 * robot.v_max[4]  # its own level had to pass it
    stands = standing_of(limits, kin, v, 0.0)
    assert stands.word == AT_BOUND
    assert stands.amounts[0][1] == "rad/s"


def test_a_joint_that_runs_into_its_stop_is_short() -> None:
    robot = get_robot("hrp2")
    q = robot.q_half_sitting.copy()
    limits = JointLimitsTask("limits", robot, margin=0.05)
    q[robot.nq_base + 3] = limits.q_high[3]
    v = np.zeros(robot.nv)
    v[robot.nv_base + 3] = 0.2
    stands = standing_of(limits, robot.at(q), v, 0.0)
    assert stands.word == SHORT
    assert stands.amounts == ((pytest.approx(0.2 / limits.rate), "rad"),)


def test_a_posture_is_left_over_by_what_it_lacks() -> None:
    robot = get_robot("hrp2")
    q = robot.q_half_sitting
    posture = PostureTask("posture", robot, q[robot.nq_base :] + 0.2, rate=2.0)
    stands = standing_of(posture, robot.at(q), np.zeros(robot.nv), 0.0)
    assert stands.word == LEFT_OVER
    assert stands.amounts[0][0] == pytest.approx(0.2)
