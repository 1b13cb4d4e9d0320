"""What is guessed of a description: it loads, and the robot stands over what it was given."""

from __future__ import annotations

import shutil
from importlib import metadata
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from test_mjcf import FLOATING

from arms import arm_urdf
from equipoise.cli import cli
from equipoise.contacts import SupportPolygon
from equipoise.motion import InverseKinematics
from equipoise.robots import Robot, check_urdf, load_robot
from equipoise.robots.guess import guess_yaml
from equipoise.tasks import FramePoseTask


def completed(urdf: Path) -> Robot:
    yaml = urdf.with_suffix(".yaml")
    yaml.write_text(guess_yaml(urdf), encoding="utf-8")
    assert [f for f in check_urdf(yaml) if f.severity == "error"] == []
    return load_robot(yaml)


def test_an_arm_is_fixed_and_holds(tmp_path: Path) -> None:
    path = tmp_path / "arm.urdf"
    path.write_text(arm_urdf())
    robot = completed(path)
    assert (robot.base.kind, robot.nv, [palm.frame for palm in robot.palms]) == (
        *("fixed", 6),
        ["link6"],
    )


def test_a_biped_gets_soles_knees_and_balance(tmp_path: Path) -> None:
    """The feet are boxes of 0.1 m by 0.1 m by 0.05 m about the ankles' ends."""
    import runpy

    example = Path(__file__).parents[2] / "examples" / "05_own_robot.py"
    path = tmp_path / "biped.urdf"
    path.write_text(runpy.run_path(str(example))["urdf"]())
    robot = completed(path)
    assert robot.base.kind == "floating"
    assert len(robot.soles) == 2
    kin = robot.at(robot.q_half_sitting)
    for sole in robot.soles:
        T = kin.placement(sole.frame)
        assert np.abs(T.rotation - np.eye(3)).max() < 1e-6
        assert T.translation[2] == pytest.approx(0.0, abs=1e-4)
        sides = (sole.x_min, sole.x_max, sole.y_min, sole.y_max)
        assert sides == pytest.approx((-0.05, 0.05, -0.05, 0.05), abs=1e-3)
    knees = [robot.q_half_sitting[robot.nq_base + robot.joint_index(f"{s}_knee_joint")]
             for s in ("left", "right")]  # fmt: skip
    assert knees == pytest.approx([0.7, 0.7])
    corners = [kin.placement(s.frame).act(c) for s in robot.soles for c in s.corners]
    assert SupportPolygon.of_points(np.array(corners)).margin(kin.p_world_com) > 0.02


@pytest.mark.parametrize(
    ("name", "radius"),
    [("solo_description/robots/solo12", 0.016), ("go2_description/urdf/go2", 0.022)],
)  # fmt: skip
def test_a_quadruped_gets_four_points(tmp_path: Path, name: str, radius: float) -> None:
    try:
        files = metadata.files("example-robot-data") or []
    except metadata.PackageNotFoundError:
        pytest.skip("example-robot-data is not installed")
    (found,) = [file for file in files if str(file).endswith(f"/{name}.urdf")]
    path = Path(str(found.locate())).resolve()
    yaml = tmp_path / "mine.yaml"
    yaml.write_text(guess_yaml(path).replace(f"urdf: {path.name}", "urdf: {package: "
                    f"example-robot-data, file: robots/{name}.urdf}}"))  # fmt: skip
    robot = load_robot(yaml)
    assert len(robot.feet) == 4
    assert [foot.radius for foot in robot.feet] == pytest.approx([radius] * 4, abs=2e-3)
    kin = robot.at(robot.q_half_sitting)
    points = np.array([kin.placement(foot.frame).translation for foot in robot.feet])
    assert np.ptp(points[:, 2]) < 1e-3
    assert SupportPolygon.of_points(points).margin(kin.p_world_com) > 0.05


def test_the_command_prints_it(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    path = tmp_path / "crooked.xml"
    path.write_text(FLOATING)
    said = CliRunner().invoke(cli, ["robots", "new", str(path)]).stdout
    assert said.startswith("# Guessed from crooked.xml")
    assert "mjcf: crooked.xml" in said
    assert "  pan: 0.5" in said
    assert CliRunner().invoke(cli, ["robots", "new"]).exit_code != 0
    assert CliRunner().invoke(cli, ["robots", "hrp2", "talos"]).exit_code != 0
    shutil.rmtree(tmp_path)


ROVER = """
<mujoco model="rover">
  <worldbody>
    <body name="chassis" pos="0 0 0.15">
      <freejoint/>
      <geom type="box" size="0.3 0.2 0.05" mass="20"/>
      <body name="wl" pos="0 0.25 -0.05">
        <joint name="wheel_l" axis="0 1 0"/><geom type="cylinder" size="0.1 0.03" mass="1"/>
      </body>
      <body name="wr" pos="0 -0.25 -0.05">
        <joint name="wheel_r" axis="0 1 0"/><geom type="cylinder" size="0.1 0.03" mass="1"/>
      </body>
      <body name="link1" pos="0 0 0.05">
        <joint name="j1" axis="0 0 1" range="-3 3" limited="true"/>
        <geom type="capsule" fromto="0 0 0 0.4 0 0.1" size="0.05" mass="3"/>
        <site name="tool" pos="0.4 0 0.1"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


def test_a_rover_drives_in_the_plane_and_its_wheels_are_no_hands(tmp_path: Path) -> None:
    (tmp_path / "rover.xml").write_text(ROVER)
    text = guess_yaml(tmp_path / "rover.xml")
    assert "base: planar" in text
    assert "frame: tool" in text
    assert "wheel_l_hand" not in text
    (tmp_path / "rover.yaml").write_text(text)
    robot = load_robot(tmp_path / "rover.yaml")
    assert robot.joint_names == ("base_x", "base_y", "base_yaw", "j1")
    assert robot.mass == pytest.approx(25.0)
    target = robot.at(robot.q_half_sitting).placement("tool").copy()
    target.translation += np.array([1.0, -0.5, 0.0])
    ik = InverseKinematics(robot, [FramePoseTask("tool", "tool", target)])
    there = robot.at(ik.settle().q_ref).placement("tool")
    assert np.linalg.norm(there.translation - target.translation) < 1e-3
