"""A walk with something in the hands: a tray goes along, a box is pushed, both in closed loop."""

from __future__ import annotations

import numpy as np
import pytest

from equipoise.contacts import Phase
from equipoise.errors import ScenarioError
from equipoise.robots import Robot, get_robot, named_robots
from equipoise.scenarios import read_scenario
from equipoise.simulation.build.setup import build_setup
from equipoise.simulation.simulation import Simulation
from equipoise.studies.in_memory import run_in_memory

TWO_STEPS = ["walk.along.count=2", "duration=4.2"]


def ticks_of(simulation, names):
    log = {name: [] for name in ("t", *names)}
    for t, record in simulation.ticks():
        log["t"].append(t)
        for name in names:
            log[name].append(record[name].copy())
    return {name: np.array(values) for name, values in log.items()}


@pytest.mark.parametrize(
    ("robot", "engine", "share"),
    [
        ("hrp2", "rigid", 0.05),
        ("hrp2", "mujoco", 0.1),
        pytest.param("talos", "mujoco", 0.1, marks=pytest.mark.slow),
        pytest.param("g1", "mujoco", 0.1, marks=pytest.mark.slow),
    ],
)
def test_a_tray_is_carried_along(robot, engine, share):
    if engine == "mujoco":
        pytest.importorskip("mujoco")
    if named_robots()[robot].missing:
        pytest.skip(f"{robot} is not installed")
    changes = [*TWO_STEPS, f"physics.engine={engine}"]
    scenario = read_scenario("walk_tray", changes, robot=None if robot == "hrp2" else robot)
    ticks = run_in_memory(Simulation(scenario), stop_when_off=True)
    found = ticks.metrics(["walk_steps", "force_error_share", "object_tilt", "switch_jump"])
    assert found["walk_steps"] == 2.0
    assert found["force_error_share"] < share
    assert found["object_tilt"] < np.radians(5.0)
    assert found["switch_jump"] < 1e-3
    assert ticks.metrics(["walk_distance"])["walk_distance"] > 0.95 * scenario.walk.along.forward


def push(lean: bool) -> dict[str, np.ndarray]:
    """Push until the second step is in the air; return what was logged from 3.5 s on."""
    changes = ["duration=4.4", f"walk.lean={str(lean).lower()}"]
    names = ["lam/left_sole", "lam/right_sole", "lam/left_push", "lam/right_push", "q"]
    names += ["walk/zmp", "walk/phase", "walk/carries", "slider/box"]
    log = ticks_of(Simulation(read_scenario("push_box", changes)), names)
    return {name: values[log["t"] > 3.5][::10] for name, values in log.items()}


def pressed_at(robot: Robot, log: dict[str, np.ndarray]) -> np.ndarray:
    """Return where the soles press (N,) [m], along x, from their wrenches and places."""
    total, moment = 0.0, 0.0
    for sole in robot.soles:
        x = np.array([robot.at(q).placement(sole.frame).translation[0] for q in log["q"]])
        lam = log[f"lam/{sole.name}"]
        total = total + lam[:, 2]
        moment = moment + lam[:, 2] * x - lam[:, 4]
    return moment / total


def test_who_leans_into_a_push_presses_where_it_was_planned():
    """And who does not presses behind it, by F z / (M g)."""
    pytest.importorskip("mujoco")
    robot = get_robot("hrp2")
    leans, stands = push(lean=True), push(lean=False)
    assert leans["slider/box"][-1, 0] > 0.05  # the box moves
    behind = [float((log["walk/zmp"][:, 0] - pressed_at(robot, log)).mean())
              for log in (leans, stands)]  # fmt: skip
    force = sum(stands[f"lam/{side}_push"][:, 0].mean() for side in ("left", "right"))
    lever = force * 0.92 / (robot.mass * 9.81)  # 0.92 m: the height of the hands
    assert abs(behind[0]) < 0.2 * lever
    assert behind[1] - behind[0] == pytest.approx(lever, rel=0.15)
    codes, carries = leans["walk/phase"], leans["walk/carries"]
    assert (codes[carries == 0.0] == Phase.FREE.code).mean() > 0.9
    assert np.isin(codes[carries == 1.0], [Phase.HELD.code, Phase.TOUCHED.code]).all()


def test_what_is_carried_needs_a_walk():
    text = ["world.objects.tray.carried=true"]
    with pytest.raises(ScenarioError, match=r"world\.objects\.tray\.carried.*walks"):
        build_setup(read_scenario("tray", text))


def test_a_box_is_not_for_the_rigid_engine():
    with pytest.raises(ScenarioError, match="several hands"):
        Simulation(read_scenario("push_box", ["physics.engine=rigid"]))
