"""Meshes in collisions are their convex hulls: as boxes of the same size, touching or inside."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import coal
import numpy as np
import pinocchio as pin
import pytest

from equipoise.collision.distances import DistanceEvaluator
from equipoise.collision.scene import Body, Scene, Shape
from equipoise.contacts import ContactStack, SoleContact
from equipoise.errors import RobotFileError
from equipoise.hqp import make_solver
from equipoise.motion import MotionGenerator
from equipoise.robots import Robot, check_urdf, load_robot
from equipoise.robots.hulls import OPTIONS, _hull, _with_extent
from equipoise.spatial import pose
from equipoise.tasks import AvoidanceTask, ContactTask, FramePoseTask, JointLimitsTask
from equipoise.trajectories import FixedPose

INERTIAL = (
    '<inertial><mass value="1"/>'
    '<inertia ixx=".01" ixy="0" ixz="0" iyy=".01" iyz="0" izz=".01"/></inertial>'
)
FACES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))


def box(size: tuple[float, float, float], at=(0.0, 0.0, 0.0)) -> tuple[np.ndarray, list]:
    """Return corners and outward faces of a box."""
    signs = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    return np.array(signs) * np.array(size) / 2.0 + np.array(at), list(FACES)


def obj(path: Path, *parts: tuple[np.ndarray, list]) -> None:
    """Write parts as one OBJ file, faces cut into triangles."""
    lines, first = [], 1
    for corners, faces in parts:
        lines += [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in corners]
        for face in faces:
            for a, b in pairwise(face[1:]):
                lines.append(f"f {face[0] + first} {a + first} {b + first}")
        first += len(corners)
    path.write_text("\n".join(lines) + "\n")


def carrier(folder: Path, geometry: str, name: str = "carrier") -> Robot:
    """Return three slides that carry a tip of one collision shape."""

    def slide(joint: str, parent: str, child: str, axis: str) -> str:
        return (
            f'<joint name="{joint}" type="prismatic"><parent link="{parent}"/>'
            f'<child link="{child}"/><axis xyz="{axis}"/>'
            '<limit lower="-2" upper="2" velocity="5" effort="50"/></joint>'
        )

    links = "".join(f'<link name="{link}">{INERTIAL}</link>' for link in ("foot", "a", "b"))
    links += (
        f'<link name="tip">{INERTIAL}<collision><geometry>{geometry}</geometry></collision></link>'
    )
    joints = slide("x", "foot", "a", "1 0 0") + slide("y", "a", "b", "0 1 0")
    joints += slide("z", "b", "tip", "0 0 1")
    path = folder / f"{name}.urdf"
    path.write_text(f'<robot name="{name}">{links}{joints}</robot>')
    sole = "{name: s, frame: foot, x_min: -0.1, x_max: 0.1, y_min: -0.1, y_max: 0.1}"
    path.with_suffix(".yaml").write_text(f"soles:\n  - {sole}\n")
    return load_robot(path)


def distance(robot: Robot, shape: Shape, at: pin.SE3):
    """Return distance and normal from the tip to a body at a place."""
    scene = Scene(robot, (Body("other", (shape,), at),))
    found = DistanceEvaluator(scene, [scene.pair("tip", "other")])
    far = found.at(robot.at(robot.q_half_sitting))[0]
    return float(far), found.witness(0).normal


@pytest.mark.parametrize("shape", ["box", "sphere", "cylinder"])
@pytest.mark.parametrize(
    "at",
    [(0, 0, 0.01), (0.02, 0.01, 0), (0.09, 0, 0), (0.1, 0, 0), (0.1 + 1e-9, 0, 0), (0, -0.12, 0),
     (0.3, 0.2, 0.1), (0, 0, 0.2)],
)  # fmt: skip
def test_a_mesh_of_a_box_is_as_far_as_the_box(tmp_path, shape, at):
    obj(tmp_path / "cube.obj", box((0.1, 0.12, 0.14)))
    plain = carrier(tmp_path, '<box size="0.1 0.12 0.14"/>', "plain")
    meshed = carrier(tmp_path, '<mesh filename="cube.obj"/>', "meshed")
    other = Shape(shape, (0.1, 0.1, 0.1), pose((0, 0, 0)))
    far, normal = distance(plain, other, pose(at))
    found, towards = distance(meshed, other, pose(at))
    assert found == pytest.approx(far, abs=2e-6)
    if far > 1e-6:
        assert np.allclose(towards, normal, atol=1e-3)


@pytest.mark.parametrize("at", [(0, 0, 0), (0.01, -0.01, 0.02), (0.03, 0.03, 0.03)])
@pytest.mark.parametrize("size", [0.001, 0.04])
def test_a_thing_inside_a_mesh_is_inside(tmp_path, at, size):
    obj(tmp_path / "cube.obj", box((0.1, 0.1, 0.1)))
    robot = carrier(tmp_path, '<mesh filename="cube.obj"/>')
    for kind in ("sphere", "box", "cylinder"):
        found, _ = distance(robot, Shape(kind, (size,) * 3, pose((0, 0, 0))), pose(at))
        assert found <= -(0.05 - max(at)) - size / 2.0 + 2e-6


@pytest.mark.parametrize("goal", [(0.3, 0.0, 0.0), (0.3, 0.05, -0.02)])
def test_a_touching_mesh_is_not_pushed_into_the_obstacle(tmp_path, goal):
    obj(tmp_path / "cube.obj", box((0.1, 0.1, 0.1)))
    robot = carrier(tmp_path, '<mesh filename="cube.obj"/>')
    scene = Scene(
        robot, (Body("wall", (Shape("box", (0.1, 1, 1), pose((0, 0, 0))),), pose((0.1, 0, 0))),)
    )
    kin = robot.at(robot.q_half_sitting)
    levels = [
        [ContactTask("c", ContactStack([SoleContact.standing(robot.soles[0], kin)]))],
        [JointLimitsTask("l", robot), AvoidanceTask("off", scene, [scene.pair("tip", "wall")])],
        [FramePoseTask("go", "tip", FixedPose(pose(goal)))],
    ]
    motion = MotionGenerator(robot, levels, make_solver("active_set"), 0.005, robot.q_half_sitting)
    for k in range(600):
        step = motion.step(0.005 * k)
    assert step.kin.placement("tip").translation[0] <= 1e-3


def test_a_hollow_counts_as_solid_and_is_told(tmp_path):
    """A table of a plate on two walls: its hull is the whole block, seven times its volume."""
    parts = [box((0.7, 0.5, 0.02), (0, 0, 0.24))]
    parts += [box((0.02, 0.5, 0.24), (x, 0, 0.11)) for x in (-0.34, 0.34)]
    obj(tmp_path / "table.obj", *parts)
    robot = carrier(tmp_path, '<mesh filename="table.obj"/>')
    [found] = [str(f) for f in check_urdf(tmp_path / "carrier.urdf")]
    assert "convex hull" in found
    assert "'table.obj'" in found
    ball = Shape("sphere", (0.02,) * 3, pose((0, 0, 0)))
    assert distance(robot, ball, pose((0.0, 0.0, 0.1)))[0] < 0.0


@pytest.mark.parametrize("turned", [0.0, 0.4])
def test_a_convex_mesh_is_not_talked_about(tmp_path, turned):
    corners, faces = box((0.1, 0.2, 0.3))
    obj(tmp_path / "cube.obj", (corners @ pin.exp3(np.full(3, turned)).T, faces))
    carrier(tmp_path, '<mesh filename="cube.obj" scale="1 2 -1"/>')
    assert check_urdf(tmp_path / "carrier.urdf") == []


@pytest.mark.parametrize(
    ("thin", "axes"), [(0.0, (2,)), (1e-9, (2,)), (1e-6, (0, 2)), (1e-3, (2,))]
)
def test_flat_meshes_and_lines_have_a_distance(tmp_path, thin, axes):
    corners, faces = box((0.1, 0.1, 0.1))
    for axis in axes:
        corners[:, axis] *= thin
    obj(tmp_path / "flat.obj", (corners, faces))
    robot = carrier(tmp_path, '<mesh filename="flat.obj"/>')
    ball = Shape("sphere", (0.02,) * 3, pose((0, 0, 0)))
    for height in (0.05, -0.05):
        assert distance(robot, ball, pose((0, 0, height)))[0] == pytest.approx(0.04, abs=1e-4)
    assert distance(robot, ball, pose((0, 0, 0)))[0] < -0.009


BROKEN = {
    "nan": "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    "far": "v 1e30 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    "empty": "",
    "no faces": "v 0 0 0\nv 1 0 0\nv 0 1 0\n",
    "no such corner": "v 0 0 0\nf 1 2 3\n",
    "outside": "mtllib ../../secret.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    "binary": "\x00\x01\x02",
}


@pytest.mark.parametrize("case", BROKEN)
def test_broken_meshes_are_refused(tmp_path, case):
    (tmp_path / "broken.obj").write_text(BROKEN[case])
    with pytest.raises(RobotFileError):
        carrier(tmp_path, '<mesh filename="broken.obj"/>')


def test_a_robot_made_by_hand_has_hulls_in_its_scene(tmp_path):
    obj(tmp_path / "cube.obj", box((0.1, 0.1, 0.1)))
    robot = carrier(tmp_path, '<mesh filename="cube.obj"/>')
    hollow = coal.MeshLoader().load(str(tmp_path / "cube.obj"), np.ones(3))
    robot.collision_model.geometryObjects[0].geometry = hollow
    ball = Shape("sphere", (0.02,) * 3, pose((0, 0, 0)))
    assert distance(robot, ball, pose((0, 0, 0)))[0] == pytest.approx(-0.06, abs=1e-6)


def test_any_cloud_of_corners_has_a_hull(rng):
    """Of any size and flatness: where qhull gave up inside Coal, the process would end here."""
    for _ in range(200):
        points = rng.normal(size=(int(rng.integers(4, 40)), 3)) * 10.0 ** rng.uniform(-6, 2, size=3)
        corners, volume = _hull(_with_extent(points + rng.normal(size=3) * 1e3))
        given = coal.StdVec_Vec3s()
        for corner in corners:
            given.append(corner)
        assert volume > 0.0
        assert coal.Convex.convexHull(given, True, OPTIONS).num_points >= 4
