"""Walks in closed loop: on every named humanoid in both engines, and what is refused before."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

from equipoise import run_scenario
from equipoise.errors import ScenarioError
from equipoise.robots import get_robot, named_robots
from equipoise.scenarios import parse_scenario, read_scenario
from equipoise.simulation.build.assemble import starting_posture
from equipoise.simulation.build.rehearse import rehearse
from equipoise.simulation.build.setup import build_setup
from equipoise.simulation.build.walk import build_walk
from equipoise.simulation.simulation import Simulation
from equipoise.studies.in_memory import run_in_memory
from equipoise.walking.feet import turn_between, yaw_of
from equipoise.walking.footsteps import after

ROBOTS = ("hrp2", "talos", "g1")


def met(run):
    return not {n: r for n, r in run.summary["metrics"].items() if not r.get("passed", True)}


def require(robot, engine):
    if named_robots()[robot].missing:
        pytest.skip(f"{robot} is not installed")
    if engine == "mujoco":
        pytest.importorskip("mujoco")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("robot", "engine"), [("hrp2", "rigid"), *((robot, "mujoco") for robot in ROBOTS)]
)
def test_two_steps_meet_their_acceptance(robot: str, engine: str, tmp_path: Path) -> None:
    require(robot, engine)
    overrides = [f"physics.engine={engine}", "walk.along.count=2", "duration=4.6",
                 "acceptance.limits.walk_steps={min: 2}"]  # fmt: skip
    run = run_scenario(
        "walk", out=tmp_path / "run", robot=robot, overrides=overrides, figures=False
    )
    assert met(run)
    step = run["q"][-1, 0] - run["q"][0, 0]
    wanted = read_scenario("walk", robot=robot).walk.along.forward
    assert step == pytest.approx(wanted, abs=0.01)  # the second step closes
    assert any("touches" in said for said in run.summary["changes"])


@pytest.mark.slow
def test_an_ankle_feels_next_to_nothing_of_the_lift():
    """What a foot carries is taken off its ankle when it lifts: 6.5 N were 8 mrad on G1."""
    require("g1", "rigid")
    lifts = 2.7  # [s]
    overrides = ["physics.engine=rigid", f"duration={lifts + 0.2}"]
    scenario = read_scenario("slow_steps", overrides, robot="g1")
    ticks = run_in_memory(Simulation(scenario), stop_when_off=True)
    assert any("lifts" in said for said in ticks.simulation.story)
    assert np.abs(ticks.run["dq"][:, 6:]).max() < 0.005  # [rad]


@pytest.mark.slow
def test_it_turns_and_stops_when_it_is_told(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    overrides = ["walk.along={count: 6, forward: 0.1, turn: 0.1}", "walk.stop=2.0", "duration=5.0",
                 "acceptance.limits.walk_steps={min: 2}"]  # fmt: skip
    run = run_scenario("walk", out=tmp_path / "run", overrides=overrides, figures=False)
    assert met(run)
    assert run["walk/carries"][-1].tolist() == [1.0, 1.0]
    assert (np.diff(run["walk/carries"], axis=0) > 0.0).sum() == 2  # the step, and one that closes
    robot = get_robot("hrp2")
    kin = robot.at(run["q"][-1])
    left, right = (yaw_of(kin.placement(sole.frame)) for sole in robot.soles)
    assert abs(left - right) < 0.02
    assert left == pytest.approx(0.2, abs=0.02)


def planned(changes, robot=None):
    scenario = read_scenario("walk", changes, robot=robot)
    return build_walk(scenario, build_setup(scenario))


def test_a_goal_and_a_list_of_footsteps_are_ways_too():
    walk = planned(["walk={to: {goal: [0.5, 0.2, 0.4]}}"])
    stance = after(walk.plan.stance, [one.footstep for one in walk.plan.steps])
    middle = walk.planner.feet.middle(stance)
    assert np.allclose(middle.translation[:2], [0.5, 0.2], atol=1e-6)
    assert abs(turn_between(yaw_of(middle), 0.4)) < 1e-9
    steps = "{foot: right, xyz: [0.1, -0.095, 0.0]}, {foot: left, xyz: [0.1, 0.095, 0.0]}"
    walk = planned([f"walk={{steps: [{steps}]}}"])
    assert [one.footstep.T_world_sole.translation[0] for one in walk.plan.steps] == [0.1, 0.1]


def test_what_cannot_be_walked_is_refused_before_the_run():
    for changes, said in (
        (["walk.timing.single=0.1"], r"walk: step \d+ \((left|right) foot\) is too"),
        (["walk.mode=slow"], "walk: the walk cannot be balanced at step 1"),
        (
            ["walk={steps: [{foot: left, xyz: [0.0, -0.02, 0.0]}]}"],
            "step 1 .* meets the other foot",
        ),
        (["walk={along: {count: 2}, to: {goal: [1.0, 0.0, 0.0]}}"], "exactly one of"),
        (["contacts={left_sole: {kind: sole, sole: left_sole}}"], "both feet have to stand"),
        (["walk.rate=2000.0"], "too fast for control.period"),
    ):
        with pytest.raises(ScenarioError, match=said):
            planned(changes)


def test_a_leg_that_does_not_reach_is_told_before_the_run():
    scenario = read_scenario("walk", ["walk.along.forward=0.8", "walk.timing.single=2.0"])
    setup = build_setup(scenario)
    q_start = starting_posture(scenario, setup, build_walk(scenario, setup))
    with pytest.raises(ScenarioError, match=r"step \d+ \(.* foot\) is out of reach"):
        rehearse(scenario, setup, q_start)
    fast = read_scenario("walk", ["walk.timing={single: 0.4, double: 0.15}"])
    [told] = rehearse(fast, setup, q_start)
    assert "outside its soles" in told
    assert rehearse(read_scenario("press"), setup, q_start) == ()


def test_bilateral_contacts_do_not_walk():

    changes = ["physics.engine=rigid", "physics.contacts=bilateral", "duration=0.1"]
    with pytest.raises(ScenarioError, match="never lift"):
        Simulation(read_scenario("walk", changes))


def test_an_unknown_key_of_a_walk_is_told():
    text = (
        "name: a\nduration: 1.0\ncontacts: {}\ntasks: {posture: {kind: posture, priority: 1}}\n"
        "walk: {along: {count: 2}, timing: {singel: 0.5}}\n"
    )
    with pytest.raises(ScenarioError, match=r"singel.*Did you mean 'single'"):
        parse_scenario(text)


@pytest.mark.parametrize("robot", ROBOTS[1:])
def test_a_walk_scales_with_the_height_of_the_centre_of_mass(robot):
    require(robot, "rigid")
    heights = [get_robot(name).at(get_robot(name).q_half_sitting).p_world_com[2]
               for name in ("hrp2", robot)]  # fmt: skip
    strides = [read_scenario("walk", robot=name).walk.along.forward for name in (None, robot)]
    assert strides[1] / strides[0] == pytest.approx(heights[1] / heights[0], rel=1e-4)


@pytest.mark.slow
def test_it_stands_a_push_that_a_fixed_reference_falls_from(tmp_path: Path) -> None:
    """HRP-2, 120 N forward at the chest for 0.2 s, without a step; and it comes back."""
    pytest.importorskip("mujoco")
    chest = get_robot("hrp2").parts["torso"][-1]
    push = f"{{frame: {chest}, force: [120, 0, 0], start: 0.2, duration: 0.2}}"

    def height_and_place(balance: str) -> tuple[float, float]:
        overrides = [f"walk={{steps: [], balance: {balance}}}", "duration=2.2",
                     f"faults.pushes=[{push}]"]  # fmt: skip
        run = run_scenario("walk", out=tmp_path / balance[:2], overrides=overrides, figures=False)
        return np.ptp(run["q"][:, 2]), float(np.abs(run["q"][-1, :2] - run["q"][0, :2]).max())

    sunk, off = height_and_place("{}")
    assert sunk < 0.05
    assert off < 0.01
    assert height_and_place("null")[0] > 0.2


def benchmark():
    """Return benchmarks/walking.py, which has the cases of the page on walking."""
    place = Path(__file__).parents[2] / "benchmarks" / "walking.py"
    spec = importlib.util.spec_from_file_location("walking_benchmark", place)
    found = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = found
    spec.loader.exec_module(found)
    return found


@pytest.mark.slow
@pytest.mark.parametrize(
    ("robot", "case", "shorter", "base", "joints"),
    [
        ("hrp2", "plank 2 cm", ["walk.along.count=3", "duration=5.2"], 12.0, 100.0),
        ("g1", "noise", ["walk.along.count=2", "duration=3.2"], 12.0, 100.0),
        ("hrp2", "stairs", ["walk.along.count=2", "duration=6.5"], 2.0, 30.0),
    ],
)
def test_it_walks_over_what_nobody_told_it_and_up_stairs(robot, case, shorter, base, joints):
    """Without the landing that lets go again, and with noise kept at a lift, the first two fall."""
    module = benchmark()
    require(robot, module.cases()[case].engine)
    result, ticks = module.measure(case, robot, shorter)
    assert result.walks
    assert result.base < base  # [mm]
    assert result.joints < joints  # [mrad]
    assert result.jump < 1e-6
    if case.startswith("stairs"):
        z = [ticks.simulation.walk.walker.stance[foot].translation[2] for foot in (0, 1)]
        assert max(z) == pytest.approx(module.RISE, abs=2e-3)


def test_a_switch_is_continuous_while_motors_are_relieved():
    """Relief that binds at the switch (48 % of a torque is needed) is let in little by little."""
    changes = ["physics.engine=mujoco", "duration=2.6", "control.torque_share=0.25"]
    ticks = run_in_memory(Simulation(read_scenario("walk", changes)), stop_when_off=True)
    found = ticks.metrics(["switch_jump", "torque_share"])
    assert found["torque_share"] > 0.3
    assert found["switch_jump"] < 1e-6
