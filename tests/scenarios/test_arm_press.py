"""A fixed arm reaches, presses and comes back: made for Panda, refitted to UR5, in both engines."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from equipoise import run_scenario
from equipoise.robots import get_robot, named_robots
from equipoise.robots.measures import measure
from equipoise.scenarios import read_scenario

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
