"""Momentum and manipulability: rows against Pinocchio, finite differences, and in closed loop."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from arms import write_arm
from equipoise import InverseKinematics
from equipoise.errors import InputError, NameNotFoundError, ShapeError
from equipoise.hqp import explain
from equipoise.robots import Robot, load_robot
from equipoise.scenarios import named_scenarios, parse_scenario
from equipoise.simulation.build.levels import build_levels
from equipoise.simulation.build.setup import build_setup
from equipoise.spatial import pose
from equipoise.tasks import (
    FrameAxesTask,
    FramePoseTask,
    ManipulabilityTask,
    MomentumTask,
    describe_rows,
)
from helpers import kinematics, random_state

ALL = ("x", "y", "z", "rx", "ry", "rz")


def test_rows_of_momentum_are_pinocchios(hrp2, rng):
    for axes in (ALL, ("ry", "z")):
        task = MomentumTask("spin", hrp2, axes=axes, value=np.arange(len(axes)))
        q, v = random_state(hrp2, rng)
        kin, context = kinematics(hrp2, q, v), hrp2.model.createData()
        wanted = pin.computeCentroidalMomentum(hrp2.model, context, q, v).vector
        wanted = wanted[[ALL.index(axis) for axis in axes]]
        rows = task.rows(kin, 0.0)
        assert rows.A @ v / task.scale == pytest.approx(wanted, rel=1e-11, abs=1e-11)
        assert np.array_equal(rows.lower, rows.upper)
        assert rows.lower / task.scale == pytest.approx(task.value)
        assert task.error(kin, 0.0) == pytest.approx(task.value - wanted, abs=1e-10)


def test_momentum_is_what_the_links_have(hrp2, rng):
    """Of each link mass and inertia, its motion by finite differences of its placement."""
    q, v = random_state(hrp2, rng)
    h, kin = 1e-6, kinematics(hrp2, q)
    ends = [kinematics(hrp2, pin.integrate(hrp2.model, q, s * v)) for s in (h, -h)]
    angular, linear = np.zeros(3), np.zeros(3)
    for joint in range(1, hrp2.model.njoints):
        body, T = hrp2.model.inertias[joint], kin.joint_placement(joint)
        one, other = (end.joint_placement(joint) for end in ends)
        speed = (one.act(body.lever) - other.act(body.lever)) / (2 * h)
        turn = pin.log3(one.rotation @ other.rotation.T) / (2 * h)
        linear += body.mass * speed
        angular += np.cross(T.act(body.lever) - kin.p_world_com, body.mass * speed)
        angular += T.rotation @ body.inertia @ T.rotation.T @ turn
    task = MomentumTask("all", hrp2, axes=ALL)
    found = task.rows(kin, 0.0).A @ v / task.scale
    assert found == pytest.approx(np.concatenate((linear, angular)), rel=1e-6, abs=1e-5)


def test_arms_swing_against_each_other(hrp2):
    """A hand is led aside: with the momentum above the posture the robot turns against it."""
    T = kinematics(hrp2, hrp2.q_half_sitting).placement("left_palm")
    spins = []
    for more in ([], [MomentumTask("spin", hrp2, axes=("rz",))]):
        hand = FramePoseTask("hand", "left_palm", pose((0.0, 0.15, 0.0)) * T, rate=3.0)
        ik = InverseKinematics(hrp2, [[hand], more] if more else [[hand]], period=5e-3)
        task, largest = MomentumTask("look", hrp2, axes=("rz",)), 0.0
        for _ in range(60):
            step = ik.step()
            kin = kinematics(hrp2, step.q_ref, step.v_ref)
            largest = max(largest, abs(task.error(kin, 0.0)[0]))
        spins.append(largest)
    assert spins[0] > 0.05
    assert spins[1] < 0.02 * spins[0]


def robots(folder: Path) -> list[tuple[Robot, str]]:
    """Return an arm, one on a floating base, and one of which two joints follow another."""
    path = write_arm(folder, "fixed")
    coupled = folder / "coupled.urdf"
    text = path.read_text()
    for joint, ratio in (("joint5", 0.5), ("joint4", -1.5)):
        at = text.index("</joint>", text.index(f'name="{joint}"'))
        text = f'{text[:at]}<mimic joint="joint2" multiplier="{ratio}"/>{text[at:]}'
    coupled.write_text(text)
    coupled.with_suffix(".yaml").write_text(path.with_suffix(".yaml").read_text())
    return [
        (load_robot(path), "hand"),
        (load_robot(write_arm(folder, "floating")), "hand"),
        (load_robot(coupled), "hand"),
    ]


@pytest.mark.parametrize("part", ["position", "rotation", "both"])
def test_the_gradient_is_the_rate_of_the_logarithm(tmp_path, rng, part):
    for robot, frame in robots(tmp_path):
        if part == "both" and robot.na < 6:
            continue
        task = ManipulabilityTask("dexterous", robot, frame, 0.3, part=part, rate=2.0)
        for _ in range(3):
            q, v = random_state(robot, rng)
            row, h = task.rows(kinematics(robot, q), 0.0), 1e-6
            logs = [
                np.log(task.value(kinematics(robot, pin.integrate(robot.model, q, s * v))))
                for s in (h, -h)
            ]
            rate = (logs[0] - logs[1]) / (2 * h)
            assert row.A[0] @ v == pytest.approx(rate, rel=1e-6, abs=1e-7)
            now = np.log(task.value(kinematics(robot, q)))
            assert row.lower[0] == pytest.approx(2.0 * (np.log(0.3) - now), abs=1e-12)
            assert row.upper[0] == np.inf


def test_a_stretched_arm_has_no_gradient(tmp_path):
    robot, frame = robots(tmp_path)[0]
    task = ManipulabilityTask("dexterous", robot, frame, 0.01, part="both")
    row = task.rows(kinematics(robot, np.zeros(6)), 0.0)  # all joints in one line
    assert row.lower[0] == -np.inf
    assert np.isfinite(row.A).all()
    assert task.error(kinematics(robot, np.zeros(6)), 0.0)[0] == np.inf


def test_a_hand_is_not_stretched_out(tmp_path):
    """Led to where only a stretched arm is, it stops before its manipulability is too little.

    Where it stops lies above the least value by what a step of its period is curved.
    """
    robot, frame = robots(tmp_path)[0]
    start = kinematics(robot, robot.q_half_sitting)
    out = pose((2.0, 0.0, 1.0)) * start.placement(frame)
    above = []
    for period in (2e-3, 1e-2):
        values = {}
        for least in (None, 0.02):
            hand = FrameAxesTask("hand", frame, out, rate=1.0)
            keep = ManipulabilityTask("dexterous", robot, frame, least or 0.02, rate=5.0)
            ik = InverseKinematics(robot, [[keep], [hand]] if least else [[hand]], period=period)
            lowest = np.inf
            for _ in range(round(3.0 / period)):
                lowest = min(lowest, keep.value(kinematics(robot, ik.step().q_ref)))
            values[least] = lowest
        assert values[None] < 0.01
        assert values[0.02] >= 0.02
        above.append(values[0.02] - 0.02)
    assert above[0] < 0.5 * above[1] < 0.01


@pytest.mark.parametrize(
    ("make", "error", "says"),
    [
        (lambda r: MomentumTask("m", r, axes=("yaw",)), NameNotFoundError, "yaw"),
        (lambda r: MomentumTask("m", r, value=[1.0]), ShapeError, "value"),
        (lambda r: ManipulabilityTask("m", r, "BODY", 0.1), InputError, "0 joints move"),
        (lambda r: ManipulabilityTask("m", r, "left_palm", 0.0), InputError, "positive"),
        (lambda r: ManipulabilityTask("m", r, "palm", 0.1), NameNotFoundError, "palm"),
        (lambda r: ManipulabilityTask("m", r, "left_palm", 0.1, part="all"), InputError, "both"),
    ],
)
def test_what_cannot_be_is_refused(hrp2, make, error, says):
    with pytest.raises(error, match=says):
        make(hrp2)


TEXT = """
extends: press
tasks:
  spin: {kind: momentum, axes: [rz], priority: 3}
  dexterous: {kind: manipulability, frame: right_palm, least: 0.02, part: both, priority: 3}
"""


def test_a_file_says_the_same_and_explains_them():
    told = parse_scenario(TEXT, text_of=lambda name: named_scenarios()[name].read_text())
    setup = build_setup(told)
    levels = build_levels(told, setup)
    tasks = {task.name: task for level in levels for task in level}
    assert isinstance(tasks["spin"], MomentumTask)
    assert tasks["spin"].axes == ("rz",)
    assert isinstance(tasks["dexterous"], ManipulabilityTask)
    assert (tasks["dexterous"].part, tasks["dexterous"].least) == ("both", 0.02)
    ik = InverseKinematics(setup.robot, [[tasks["spin"]], [tasks["dexterous"]]])
    step = ik.step()
    words = describe_rows([tasks["spin"], tasks["dexterous"]], step.hierarchy)
    said = str(explain(step.hierarchy, step.v_ref, words)) + str(words)
    assert "the momentum about z" in said
    assert "the manipulability of right_palm" in said
