"""A fixed arm reaches, presses and comes back: made for Panda, refitted to UR5, in both engines."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from equipoise import run_scenario
from equipoise.robots import get_robot, named_robots
from equipoise.robots.measures import measure
from equipoise.scenarios import read_scenario
from equipoise.simulation.build.setup import to_waypoints

ROBOTS = ("panda", "ur5")

pytestmark = pytest.mark.skipif(
    any(named_robots()[name].missing for name in ROBOTS), reason="example-robot-data is missing"
)


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["rigid", "mujoco"])
@pytest.mark.parametrize("robot", ROBOTS)
def test_it_is_met(tmp_path: Path, robot: str, engine: str) -> None:
    if engine == "mujoco":
        pytest.importorskip("mujoco")
    finished = run_scenario(
        "arm_press", robot=robot, out=tmp_path / "run", figures=False,
        overrides=[f"physics.engine={engine}"],
    )  # fmt: skip
    assert finished.summary["passed"], finished.metrics
    pressed = finished["lam/plate"][:, 0]
    assert np.abs(pressed[finished.t < 1.9]).max() < 1e-6  # it is in the air
    at_most = pressed[(finished.t > 3.1) & (finished.t < 3.25)]
    assert at_most.max() == pytest.approx(20.0, abs=1.0)


def test_places_go_with_shoulder_and_reach() -> None:
    """The plate of the other arm lies where its own shoulder and reach put it."""
    panda, ur5 = (measure(get_robot(name)) for name in ROBOTS)
    before, after = (read_scenario("arm_press", robot=name) for name in (None, "ur5"))
    at, there = (np.array(s.contacts["plate"].surface.at.xyz) for s in (before, after))
    share = ur5.reach / panda.reach
    assert 0.5 < share < 1.2
    moved = ur5.p_world_shoulders + share * (at - panda.p_world_shoulders)
    assert there == pytest.approx(moved, abs=1e-5)


def test_a_panda_has_one_coordinate_for_its_two_fingers() -> None:
    robot = get_robot("panda")
    assert (robot.na, robot.base.kind) == (8, "fixed")
    assert robot.followers == {"panda_finger_joint2": ("panda_finger_joint1", 1.0, 0.0)}
    kin = robot.at(robot.q_half_sitting)
    opened = robot.q_half_sitting.copy()
    opened[robot.joint_index("panda_finger_joint1")] += 0.02
    after = robot.at(opened)
    hand = kin.placement("panda_hand").rotation
    for finger, side in (("panda_leftfinger", 1.0), ("panda_rightfinger", -1.0)):
        moved = hand.T @ (after.placement(finger).translation - kin.placement(finger).translation)
        assert moved == pytest.approx([0.0, side * 0.02, 0.0], abs=1e-12)


TASKS = """
name: try
robot: panda
duration: 1.2
tasks:
  limits: {kind: joint_limits, priority: 1}
  tip:
    kind: frame_axes
    frame: palm_skin
    priority: 2
    waypoints: [{t: 0.1, xyz: [0.5, 0.0, 0.40]}, {t: 0.9, xyz: [0.5, 0.1, 0.35]}]
  wrist:
    kind: joint_coupling
    priority: 3
    joints: {panda_joint5: 1.0, panda_joint7: -0.5}
    value: -0.35
  late:
    kind: frame_axes
    frame: palm_skin
    priority: 2
    window: [5.0, 9.0]
    waypoints: [{t: 0.0, xyz: [9, 9, 9]}]
  posture: {kind: posture, rate: 1.0, priority: 4}
control: {start: standing}
acceptance: {after: 0.5, limits: {task_position_error: {max: 0.001}, task_angle_error: {max: 0.5}}}
"""


def test_errors_of_everyday_tasks_are_metrics(tmp_path: Path) -> None:
    """From the log of q alone; a task that is not there yet does not count."""
    (tmp_path / "try.yaml").write_text(TASKS)
    finished = run_scenario(str(tmp_path / "try.yaml"), out=tmp_path / "run", figures=False)
    values = {name: row["value"] for name, row in finished.metrics.items()}
    assert finished.summary["passed"], values
    robot = get_robot("panda")
    spec = read_scenario(str(tmp_path / "try.yaml")).tasks["tip"]
    way = to_waypoints(spec.waypoints)
    far, turned = [], []
    for k in np.flatnonzero(finished.t >= 0.5)[::10]:
        q = finished["q"][k]
        there = way.at(float(finished.t[k])).T_world_target.translation
        far.append(np.linalg.norm(robot.at(q).placement("palm_skin").translation - there))
        a, b = (q[robot.joint_index(f"panda_joint{i}")] for i in (5, 7))
        turned.append(abs(-0.35 - a + 0.5 * b))
    assert values["task_position_error"] == pytest.approx(max(far), rel=1e-9)
    assert values["task_angle_error"] == pytest.approx(max(turned), rel=1e-9)
