"""What real descriptions hold: endless joints, coupled ones, dummy links, slips of exporters."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from arms import arm_urdf
from equipoise.errors import NameNotFoundError, RobotFileError
from equipoise.robots import Robot, check_urdf, load_robot
from equipoise.robots.files.finding import WARNING
from equipoise.robots.registry import named_robots, robot_path

LIMIT = '<limit lower="-2.8" upper="2.8" velocity="5" effort="150"/>'


def write(folder: Path, text: str, yaml: str = "") -> Path:
    path = folder / "arm.urdf"
    path.write_text(text, encoding="utf-8")
    path.with_suffix(".yaml").write_text("base: fixed\n" + yaml, encoding="utf-8")
    return path


def told(path: Path, wanted: str) -> bool:
    said = [str(finding) for finding in check_urdf(path) if finding.severity == WARNING]
    return any(re.search(wanted, one) for one in said)


@pytest.fixture
def whole(tmp_path: Path) -> Robot:
    (tmp_path / "whole").mkdir()
    return load_robot(write(tmp_path / "whole", arm_urdf()))


@pytest.mark.parametrize("limit", ["", 'lower="0" upper="0" '])
def test_a_continuous_joint_turns_a_hundred_times(tmp_path: Path, whole: Robot, limit: str) -> None:
    text = arm_urdf().replace('name="joint1" type="revolute"', 'name="joint1" type="continuous"')
    text = text.replace(LIMIT, f'<limit {limit}velocity="5" effort="150"/>', 1)
    robot = load_robot(write(tmp_path, text))
    assert robot.q_max[0] == -robot.q_min[0] == pytest.approx(200 * np.pi)
    q = np.array([7.3, 0.2, -0.4, 0.5, 0.1, 0.3])
    assert robot.at(q).placement("link6").isApprox(whole.at(q).placement("link6"), 1e-12)


COUPLED = '<mimic joint="joint2" multiplier="-0.5" offset="0.1"/>'


def coupled() -> str:
    """Return the arm whose joint5 follows joint2."""
    text = arm_urdf()
    at = text.index(LIMIT, text.index('name="joint5"'))
    return text[:at] + COUPLED + text[at:]


def test_coupled_joints_follow(tmp_path: Path, whole: Robot) -> None:
    """A posture of the file may name who follows: it says nothing."""
    path = write(tmp_path, coupled(), "half_sitting: {joint2: 0.8, joint3: 0.2, joint5: 9.9}\n")
    robot = load_robot(path)
    assert robot.joint_names == ("joint1", "joint2", "joint3", "joint4", "joint6")
    assert not told(path, "joint5")
    q = np.array([0.0, 0.8, 0.2, 0.0, 0.1 - 0.5 * 0.8, 0.0])
    there = whole.at(q).placement("link6")
    assert robot.at(robot.q_half_sitting).placement("link6").isApprox(there, 1e-12)


def test_who_locks_the_follower_moves_its_leader(tmp_path: Path) -> None:
    path = write(tmp_path, coupled(), "locked: {joint5: 0.0}\n")
    assert load_robot(path).joint_names == ("joint1", "joint2", "joint3", "joint4", "joint6")
    assert not told(path, "coupled")
    by_pattern = write(tmp_path, coupled(), 'locked: {"joint[25]": 0.0}\n')
    assert load_robot(by_pattern).joint_names == ("joint1", "joint3", "joint4", "joint6")
    assert not told(by_pattern, "coupled")


@pytest.mark.parametrize("name", sorted(named_robots()))
def test_named_robots_have_nothing_to_be_warned_of(
    name: str, caplog: pytest.LogCaptureFixture
) -> None:
    load_robot(robot_path(name))
    assert not caplog.records


def test_joints_are_locked_by_pattern(tmp_path: Path) -> None:
    path = write(tmp_path, arm_urdf(), 'locked: {"joint[3-5]": 5.0, joint4: 0.3}\n')
    robot = load_robot(path)
    assert robot.joint_names == ("joint1", "joint2", "joint6")
    whole = load_robot(write(tmp_path, arm_urdf()))
    q = np.array([0.1, 0.2, 2.8, 0.3, 2.8, 0.4])  # 5 rad is beyond the range: the nearest
    there = whole.at(q).placement("link6")
    assert robot.at(q[[0, 1, 5]]).placement("link6").isApprox(there, 1e-12)
    with pytest.raises(NameNotFoundError, match="finger"):
        load_robot(write(tmp_path, arm_urdf(), 'locked: {"finger*": 0.0}\n'))


DUMMY = """<link name="dummy"><inertial><mass value="{mass}"/><inertia ixx="{i}" ixy="{i}" ixz="{i}"
  iyy="{i}" iyz="{i}" izz="{i}"/></inertial></link>
  <joint name="j" type="fixed"><parent link="link6"/><child link="dummy"/></joint></robot>"""


@pytest.mark.parametrize(("mass", "moment"), [("1e-6", "1e-6"), ("0.2", "1e-20"), ("0", "1e-7")])
def test_negligible_inertias_are_mended(tmp_path: Path, mass: str, moment: str) -> None:
    dummy = DUMMY.format(mass=mass, i=moment)
    path = write(tmp_path, arm_urdf().replace("</robot>", dummy))
    robot = load_robot(path)
    assert robot.mass == pytest.approx(9.6 + float(mass))
    assert told(path, "link 'dummy'.*(too small to count)")
    least = min(np.linalg.eigvalsh(body.inertia)[0] for body in robot.model.inertias[1:])
    assert least > 0.0


def test_unphysical_inertias_are_refused(tmp_path: Path) -> None:
    for mass, moment in (("0.2", "1e-3"), ("5.0", "1e-6")):
        text = arm_urdf().replace("</robot>", DUMMY.format(mass=mass, i=moment))
        with pytest.raises(RobotFileError, match="no body has this inertia"):
            load_robot(write(tmp_path, text))


def test_three_slashes_of_a_package_are_a_slip(tmp_path: Path) -> None:
    folder = tmp_path / "arm_package"
    folder.mkdir()
    corners = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
    (folder / "tetra.obj").write_text(corners)
    shape = '<collision><geometry><mesh filename="package:///arm_package/tetra.obj"/></geometry>'
    text = arm_urdf().replace("</inertial></link>", f"</inertial>{shape}</collision></link>", 1)
    assert load_robot(write(folder, text)).collision_model.ngeoms == 1
    with pytest.raises(RobotFileError, match="package folder was not found"):
        load_robot(write(folder, text.replace("arm_package", "etc")))
