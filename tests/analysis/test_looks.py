"""What robots look like: close to what they collide with, on the right links."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from equipoise.analysis.rendering.looks.hrp2 import shells
from equipoise.analysis.rendering.looks.keep import meshes_of
from equipoise.analysis.rendering.looks.lofts import loft, mirrored
from equipoise.analysis.rendering.looks.mesh_files import MeshFile
from equipoise.analysis.rendering.looks.normals import with_normals
from equipoise.analysis.rendering.looks.robot_looks import looks_of
from equipoise.analysis.rendering.looks.simplify import simplified
from equipoise.analysis.rendering.stands import stands
from equipoise.collision.scene import Body, Scene, Shape
from equipoise.robots import get_robot, named_robots


def _volume(mesh) -> float:
    a, b, c = (mesh.vertices[mesh.triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0


def test_a_loft_has_the_volume_of_what_it_draws():
    """A cylinder and a box with rounded ends, and faces that look outwards."""
    pipe = loft(
        "z", [(0.0, 0.1, 0.1, 0.0, 0.0), (1.0, 0.1, 0.1, 0.0, 0.0)], exponent=2.0, rounding=1e-4
    )
    assert _volume(pipe) == pytest.approx(np.pi * 0.01, rel=0.03)
    box = loft(
        "x", [(0.0, 0.2, 0.1, 0.3, 0.0), (1.0, 0.2, 0.1, 0.3, 0.0)], exponent=60.0, rounding=1e-4
    )
    assert _volume(box) == pytest.approx(0.4 * 0.2, rel=0.06)
    assert np.allclose(box.vertices.mean(axis=0), [0.5, 0.3, 0.0], atol=0.05)
    assert _volume(mirrored(pipe)) == pytest.approx(_volume(pipe))


def test_normals_are_smooth_on_a_ball_and_sharp_on_a_cube():
    ball = loft(
        "z", [(0.0, 1.0, 1.0, 0.0, 0.0), (1e-3, 1.0, 1.0, 0.0, 0.0)], exponent=2.0, rounding=0.99
    )
    round_about = np.abs(ball.vertices[:, 2]) < 0.1
    outward = ball.vertices[round_about] * [1.0, 1.0, 0.0]
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    assert np.einsum("ij,ij->i", ball.normals[round_about], outward).min() > 0.93
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    faces = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]]
    faces += [[2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
    cube = with_normals(corners, np.array(faces))
    assert np.allclose(np.sort(np.abs(cube.normals), axis=1), [0.0, 0.0, 1.0])
    assert len(cube.vertices) == 24


def test_the_shells_of_hrp2_stay_near_its_collision_shapes():
    """What seems to touch does touch: no shell of a colliding link stands out by more than 5 cm."""
    robot = get_robot("hrp2")
    model = robot.model
    for link in {link for link, _, _ in shells()}:
        frame = model.getFrameId(link, pin.FrameType.BODY)
        boxes = [s for s in robot.collision_model.geometryObjects if s.parentFrame == frame]
        if not boxes:
            continue
        own = np.vstack([mesh.vertices for name, mesh, _ in shells() if name == link])
        low, high = np.full(3, np.inf), np.full(3, -np.inf)
        for shape in boxes:
            shape.geometry.computeLocalAABB()
            T = model.frames[frame].placement.actInv(shape.placement)
            box = shape.geometry.aabb_local
            corners = np.array([[x, y, z] for x in (box.min_[0], box.max_[0])
                                for y in (box.min_[1], box.max_[1])
                                for z in (box.min_[2], box.max_[2])])  # fmt: skip
            corners = corners @ T.rotation.T + T.translation
            low, high = np.minimum(low, corners.min(0)), np.maximum(high, corners.max(0))
        assert (own > low - 0.05).all(), link
        assert (own < high + 0.05).all(), link


def test_shells_are_mirror_images():
    by_link: dict[str, list] = {}
    for link, mesh, rgb in shells():
        by_link.setdefault(link, []).append((mesh, tuple(rgb)))
    for link, parts in by_link.items():
        if link.startswith(("LARM", "LLEG")):
            other = by_link[f"R{link[1:]}"]
            for (left, colour), (right, same) in zip(parts, other, strict=True):
                assert colour == same
                assert np.allclose(left.vertices * [1, -1, 1], right.vertices)


@pytest.mark.parametrize("name", ["talos", "g1"])
def test_named_robots_have_the_meshes_beside_their_urdfs(name):
    if named_robots()[name].missing:
        pytest.skip("needs the extra 'robots'")
    robot = get_robot(name)
    parts = looks_of(robot)
    assert len({part.joint for part in parts}) > 20
    triangles = sum(len(part.mesh.triangles) for part in parts)
    assert 10_000 < triangles < 80_000
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, robot.q_half_sitting)
    places = np.vstack([part.mesh.moved(data.oMi[part.joint]).vertices for part in parts])
    assert abs(places[:, 2].min()) < 0.03  # its soles stand on the floor
    assert 1.1 < np.ptp(places[:, 2]) < 2.0


def test_a_simpler_mesh_keeps_its_extent():
    ball = loft(
        "z", [(0.0, 0.5, 0.5, 0.0, 0.0), (0.3, 0.5, 0.5, 0.0, 0.0)], exponent=2.0, rounding=0.4
    )
    (mesh,) = simplified([(ball.vertices, ball.triangles)], 300)
    assert len(mesh.triangles) < len(ball.triangles)
    assert np.allclose(np.ptp(mesh.vertices, axis=0), np.ptp(ball.vertices, axis=0), rtol=0.06)
    assert np.allclose(np.linalg.norm(mesh.normals, axis=1), 1.0)


def test_kept_meshes_are_those_that_were_made_and_spoilt_ones_are_made_again(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    (tmp_path / "a.obj").write_text(text)
    file = MeshFile("link", tmp_path / "a.obj", pin.SE3.Identity(), np.full(3, 0.5), np.ones(3))
    (made,) = meshes_of([file], 100)
    (kept,) = Path(tmp_path / "cache").rglob("*.npz")
    (again,) = meshes_of([file], 100)
    assert np.array_equal(made.vertices, again.vertices)
    assert made.vertices.max() == pytest.approx(0.5, abs=1e-6)
    kept.write_bytes(b"spoilt")
    (anew,) = meshes_of([file], 100)
    assert np.array_equal(made.triangles, anew.triangles)


def test_only_what_hangs_stands_on_posts():
    robot = get_robot("hrp2")
    at = lambda x, z: pin.SE3(np.eye(3), np.array([x, 0.0, z]))  # noqa: E731
    wall = Body("wall", (Shape("box", (0.6, 0.04, 0.8), at(0.5, 0.9)),), at(0.0, 0.0))
    block = Body("block", (Shape("box", (0.3, 0.3, 0.5), at(2.0, 0.25)),), at(0.0, 0.0))
    top = Body("top", (Shape("box", (0.2, 0.2, 0.1), at(2.0, 0.55)),), at(0.0, 0.0))
    held = Body("held", (Shape("box", (0.2, 0.2, 0.1), at(0.0, 0.0)),), at(0.0, 0.0), "left_palm")
    assert not stands(Scene(robot, [block, top, held]))
    posts = stands(Scene(robot, [wall, block, top, held]))
    assert len(posts) == 4  # two posts, each on a plate
    places = np.vstack([part.mesh.vertices for part in posts])
    assert places[:, 2].min() == pytest.approx(0.0)
    assert places[:, 2].max() == pytest.approx(0.51)
    assert not stands(Scene(robot, [wall]), frozenset({"wall"}))
