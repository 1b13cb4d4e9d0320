"""What a robot's YAML adds to its URDF, against Pinocchio's own answers and plain geometry."""

from __future__ import annotations

import shutil
from pathlib import Path

import coal
import numpy as np
import pinocchio as pin
import pytest
from test_check import GOOD

from equipoise.errors import InputError, RobotFileError
from equipoise.robots import Robot, check_urdf, get_robot, load_robot, robot_urdf_path

HRP2 = robot_urdf_path("hrp2")


def stranger(folder: Path, yaml: str) -> Path:
    """Return a folder with HRP-2's URDF under another name and a YAML of its own."""
    place = folder / "mine"
    place.mkdir()
    shutil.copy(HRP2, place / "body.urdf")
    (place / "mine.yaml").write_text(f"name: mine\nurdf: body.urdf\n{yaml}", encoding="utf-8")
    return place


def random_state(robot: Robot, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    q = pin.randomConfiguration(
        robot.model,
        np.concatenate([-np.ones(7), robot.q_min]),
        np.concatenate([np.ones(7), robot.q_max]),
    )
    return q, rng.normal(size=robot.nv)


def test_a_folder_and_its_yaml_are_the_same_robot(tmp_path: Path) -> None:
    place = stranger(tmp_path, "camera: camera\n")
    for path in (place, place / "mine.yaml", f"{place}/"):
        robot = get_robot(path)
        assert (robot.name, robot.camera, robot.na) == ("mine", "camera", 30)
    assert not [f for f in check_urdf(place) if f.severity == "error"]


def test_a_locked_joint_is_pinocchios_reduced_model(
    tmp_path: Path, hrp2: Robot, rng: np.random.Generator
) -> None:
    angles = {"LARM_JOINT3": -0.7, "CHEST_JOINT0": 0.3}
    locked = get_robot(stranger(tmp_path, f"locked: {angles}\n"))
    q = pin.neutral(hrp2.model)
    for joint, angle in angles.items():
        q[7 + hrp2.joint_index(joint)] = angle
    ids = [hrp2.model.getJointId(joint) for joint in angles]
    reduced = pin.buildReducedModel(hrp2.model, ids, q)
    assert list(locked.model.names) == list(reduced.names)
    q, v = random_state(locked, rng)
    a = rng.normal(size=locked.nv)
    ours = pin.rnea(locked.model, locked.model.createData(), q, v, a)
    theirs = pin.rnea(reduced, reduced.createData(), q, v, a)
    assert ours == pytest.approx(theirs, abs=1e-10)


def test_frames_limits_and_inertials_are_what_the_yaml_says(tmp_path: Path, hrp2: Robot) -> None:
    yaml = """
frames:
  - {name: elbow_tip, on: LARM_LINK3, xyz: [0.1, 0.2, 0.3], rpy: [0.0, 0.0, 1.5707963267948966]}
limits:
  LARM_JOINT3: {lower: -2.0, effort: 12.5}
inertials:
  HEAD_LINK1: {mass: 2.5}
palms:
  - {name: tip, frame: elbow_tip, skin: 0.02}
"""
    robot = get_robot(stranger(tmp_path, yaml))
    frame = robot.model.frames[robot.frame_id("elbow_tip")]
    link = robot.model.frames[robot.frame_id("LARM_LINK3")]
    T = link.placement.actInv(frame.placement)
    assert T.translation == pytest.approx([0.1, 0.2, 0.3])
    assert T.rotation[:, 0] == pytest.approx([0.0, 1.0, 0.0], abs=1e-12)
    j = robot.joint_index("LARM_JOINT3")
    assert (robot.q_min[j], robot.q_max[j]) == (-2.0, hrp2.q_max[j])
    assert (robot.tau_max[j], robot.v_max[j]) == (12.5, hrp2.v_max[j])
    head = hrp2.model.inertias[hrp2.model.getJointId("HEAD_JOINT1")].mass
    assert robot.mass == pytest.approx(hrp2.mass + 2.5 - head)
    assert robot.frame_id("tip_skin")


def test_shapes_replace_those_of_the_file(tmp_path: Path) -> None:
    yaml = """
shapes:
  LARM_LINK3:
    - {capsule: {start: [0.1, 0.0, 0.0], end: [0.1, 0.3, -0.4], radius: 0.05}}
  HEAD_LINK1:
    - {box: [0.2, 0.1, 0.3], xyz: [0.0, 0.0, 0.1], collides: false}
"""
    robot = get_robot(stranger(tmp_path, yaml))
    (shape,) = robot.collision_model.geometryObjects
    assert len(robot.visual_model.geometryObjects) == 2
    link = robot.model.frames[robot.frame_id("LARM_LINK3")]
    T = link.placement.actInv(shape.placement)
    end = np.array([0.1, 0.3, -0.4]) + 0.2 * np.array([0.0, 0.6, -0.8])  # beyond the end
    middle = np.array([0.1, 0.15, -0.2]) + 0.2 * np.array([1.0, 0.0, 0.0])  # beside the line
    for point in (end, middle):
        result = coal.DistanceResult()
        distance = coal.distance(
            shape.geometry,
            coal.Transform3s(T.rotation, T.translation),
            coal.Sphere(0.01),
            coal.Transform3s(np.eye(3), point),
            coal.DistanceRequest(),
            result,
        )
        assert distance == pytest.approx(0.2 - 0.05 - 0.01, abs=1e-6)


@pytest.mark.parametrize(
    ("yaml", "wanted"),
    [
        ("frames: [{name: a, on: LARM_LINK33}]", "LARM_LINK3"),
        ("locked: {LARM_JOINT33: 0.0}", "LARM_JOINT3"),
        ("limits: {KNEE: {effort: 3.0}}", "no joint.*limits.*'KNEE'"),
        ("limits: {LARM_JOINT3: {effort: 0.0}}", "line 3, limits.LARM_JOINT3.effort.*greater"),
        ("limits: {LARM_JOINT3: {torque: 1.0}}", "unknown key.*Known: lower, upper, velocity"),
        ("shapes: {BODY: [{box: [1.0, 1.0, 1.0], sphere: 0.1}]}", "exactly one"),
        ("shapes: {BODY: [{capsule: {start: [0.0, 0.0, 0.0], end: [0.0, 0.0, 0.0], radius: 1.0}}]}",
         "one point"),
        ("shapes: {TORSO: []}", "no link.*shapes.*'TORSO'"),
        ("inertials: {BODY: {mass: -1.0}}", "greater than 0"),
        ("parts: {head: HEAD}", "'HEAD'"),
        ("locked: {LARM_JOINT3: .nan}", "finite"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_by_name(tmp_path: Path, yaml: str, wanted: str) -> None:
    place = stranger(tmp_path, f"{yaml}\n")
    with pytest.raises(InputError, match=wanted):
        load_robot(place)


@pytest.mark.parametrize(
    ("urdf", "wanted"),
    [
        ("none.urdf", "there is no URDF"),
        ("{package: no-such-package, file: a.urdf, extra: robots}", r"equipoise\[robots\]"),
        ("{package: numpy, file: no_such.urdf, extra: robots}", "has no such file"),
    ],
)
def test_a_urdf_that_is_not_there(tmp_path: Path, urdf: str, wanted: str) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(f"urdf: {urdf}\n", encoding="utf-8")
    with pytest.raises(InputError, match=wanted):
        get_robot(path)


def test_an_empty_folder_is_no_robot(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=f"{tmp_path.name}.yaml"):
        get_robot(tmp_path)


def test_a_check_sends_to_the_yaml_that_was_given(tmp_path: Path) -> None:
    place = stranger(tmp_path, "palms: [{name: left_palm, frame: left_palm}]\n")
    findings = [str(finding) for finding in check_urdf(place)]
    yaml = next(place.glob("*.yaml")) if place.is_dir() else place
    assert f"List the soles in {yaml.name}, or" in " ".join(findings)
    yaml.write_text(yaml.read_text(encoding="utf-8") + "locked: {LARM_JOINT33: 0.0}\n")
    (refused,) = check_urdf(place)
    assert str(refused).endswith("?")


MOVING = (
    '<link name="more"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" '
    'izz="1"/></inertial></link><joint name="last" type="revolute"><parent link="tip"/>'
    '<child link="more"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
)


@pytest.mark.parametrize(
    ("value", "fits"),
    [(0.5, True), (1.25, True), (-1.5, True), (1.2500005, True), (1.26, False), (-1.6, False),
     (30.0, False), (1e300, False)],
)  # fmt: skip
def test_a_joint_is_locked_only_inside_its_range(tmp_path, value, fits):
    (tmp_path / "two.urdf").write_text(GOOD)
    (tmp_path / "two.yaml").write_text(f"locked: {{elbow: {value}}}\n")
    found = [str(f) for f in check_urdf(tmp_path / "two.urdf") if f.severity == "error"]
    if fits:
        assert not any("lock" in one for one in found)
        return
    assert len(found) == 1
    assert "range is -1.5 to 1.25 rad" in found[0]
    with pytest.raises(RobotFileError, match="cannot be locked there"):
        get_robot(tmp_path / "two.urdf")


def test_a_joint_without_stops_is_locked_within_two_turns(tmp_path):
    text = GOOD.replace("revolute", "continuous").replace("</robot>", MOVING + "</robot>")
    (tmp_path / "two.urdf").write_text(text)
    for value, fits in ((6.0, True), (90.0, False)):
        (tmp_path / "two.yaml").write_text(f"locked: {{elbow: {value}}}\n")
        found = check_urdf(tmp_path / "two.urdf")
        assert any("locked" in str(f) for f in found) != fits
