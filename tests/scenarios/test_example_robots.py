"""Robots of the package example-robot-data: arms reach, quadrupeds and humanoids stand and sway."""

from __future__ import annotations

from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from equipoise.api import run_scenario
from equipoise.robots import Robot, check_urdf
from example_robots import DEGREES_OF_FREEDOM, FILES, load_example, write_example

try:
    metadata.version("example-robot-data")
except metadata.PackageNotFoundError:
    pytest.skip("example-robot-data is not installed", allow_module_level=True)

HANDS = {
    "panda": ("panda_hand_tcp",),
    "ur5": ("tool0",),
    "baxter": ("left_gripper", "right_gripper"),
    "tiago_pro": ("arm_left_tool_link",),
}
TRUNKS = {
    "solo12": "base_link", "anymal": "base", "go2": "base", "talos": "base_link",
    "icub": "root_link", "g1_hands": "pelvis",
}  # fmt: skip
TIMES = np.linspace(0.2, 2.7, 9)


def path_of(robot: Robot, frame: str, offsets: np.ndarray, times: np.ndarray) -> dict[str, Any]:
    """Return the task that leads a frame from where it is through offsets (k, 3) [m]."""
    import pinocchio as pin

    T = robot.at(robot.q_half_sitting).placement(frame)
    rpy = [float(x) for x in pin.rpy.matrixToRpy(T.rotation)]
    waypoints = [
        {"t": float(t), "xyz": [float(x) for x in T.translation + offset], "rpy": rpy}
        for t, offset in zip(times, offsets, strict=True)
    ]
    return {"kind": "frame_path", "frame": frame, "priority": 2, "waypoints": waypoints}


def scenario(robot: Robot, yaml: Path, engine: str) -> Path:
    """Write a scenario: hands reach, or the trunk goes around a circle of 2 or 5 cm, once."""
    import json

    tasks: dict[str, Any] = {"limits": {"kind": "joint_limits", "priority": 1}}
    contacts: dict[str, Any] = {s.name: {"kind": "sole", "sole": s.name} for s in robot.soles}
    contacts |= {f.name: {"kind": "foot", "foot": f.name} for f in robot.feet}
    for k, hand in enumerate(HANDS.get(robot.name, ())):
        side = -0.08 if k else 0.08
        offsets = np.array([[0.0, 0.0, 0.0], [-0.06, side, 0.1]])
        tasks[hand] = path_of(robot, hand, offsets, np.array([0.2, 1.0]))
    if robot.name in TRUNKS:
        turn = 2.0 * np.pi * (TIMES - TIMES[0]) / (TIMES[-1] - TIMES[0])
        size = 0.05 if robot.feet and robot.name != "solo12" else 0.02
        circle = [[0.0, 0.5 * size * np.sin(a), 0.5 * size * (np.cos(a) - 1.0)] for a in turn]
        tasks["com"] = {"kind": "com_polygon", "margin": 0.02, "priority": 1}
        tasks["trunk"] = path_of(robot, TRUNKS[robot.name], np.array(circle), TIMES)
    tasks["posture"] = {"kind": "posture", "priority": 3}
    whole = {
        "name": "try", "robot": str(yaml), "contacts": contacts, "tasks": tasks,
        "duration": 3.0 if robot.name in TRUNKS else 1.4,
        "physics": {"engine": engine}, "control": {"start": "standing"},
    }  # fmt: skip
    path = yaml.with_name("try.yaml")
    path.write_text(json.dumps(whole))
    return path


@pytest.mark.parametrize("name", sorted(FILES))
def test_it_loads_as_what_it_is(tmp_path: Path, name: str) -> None:
    robot = load_example(tmp_path, name)
    assert robot.nv == DEGREES_OF_FREEDOM[name]
    assert [f for f in check_urdf(tmp_path / f"{name}.yaml") if f.severity == "error"] == []
    assert robot.base.kind == ("fixed" if name in HANDS else "floating")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "engine"),
    [
        *((name, "rigid") for name in (*HANDS, *TRUNKS)),
        *((name, "mujoco") for name in ("panda", "solo12", "anymal", "go2")),
    ],
)
def test_it_reaches_or_stands(tmp_path: Path, name: str, engine: str) -> None:
    if engine == "mujoco":
        pytest.importorskip("mujoco")
    robot = load_example(tmp_path, name)
    path = scenario(robot, write_example(tmp_path, name), engine)
    run = run_scenario(str(path), out=tmp_path / "run", figures=False)
    values = {key: row["value"] for key, row in run.metrics.items()}
    assert values["completed"] == 1.0, values
    assert values["mode_worst"] == 0.0, values
    assert values["path_error"] < (5e-4 if engine == "rigid" else 2e-3), values
    assert values["torque_share"] <= 1.0, values
    if robot.nv_base:
        assert values["reaction_normal"] > 0.0, values
        assert values["com_margin"] > 0.0, values
