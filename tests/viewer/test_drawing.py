"""What is sent of a robot: only what moved; and its ghost only where it can be seen."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest
from viewer_logs import tray_places

pytest.importorskip("viser", reason="needs the extra 'viewer': pip install -e '.[viewer]'")

from scene_poses import in_the_world

from equipoise.analysis.rendering.scene_meshes import robot_parts
from equipoise.robots import Robot
from equipoise.viewer.drawing import Drawing
from equipoise.viewer.ghost import INSET, Ghost, farthest
from equipoise.viewer.server import ViewerServer


@pytest.fixture
def sent_scene(server: ViewerServer, monkeypatch: pytest.MonkeyPatch) -> SimpleNamespace:
    robot = tray_places().robot
    parts = robot_parts(tray_places().robot)
    drawing = Drawing(server.viser.scene, "/robot", parts, robot.model.parents)
    ghost = Ghost(server.viser.scene, parts, robot.model, drawing)
    sent: list[str] = []
    queue = server.viser._websock_server.queue_message

    def note(message: object) -> None:
        sent.append(type(message).__name__)
        queue(message)

    monkeypatch.setattr(server.viser._websock_server, "queue_message", note)
    return SimpleNamespace(robot=robot, parts=parts, drawing=drawing, ghost=ghost, sent=sent)


def placements(robot: Robot, q: np.ndarray) -> list[pin.SE3]:
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, q)
    return [pin.SE3(T) for T in data.oMi]


def bent(robot: Robot, joint: int, angle: float) -> np.ndarray:
    q = robot.q_half_sitting.copy()
    q[7 + joint] += angle
    return q


def test_a_joint_that_turns_is_one_message(sent_scene: SimpleNamespace) -> None:
    robot, drawing = sent_scene.robot, sent_scene.drawing
    drawing.place(placements(robot, robot.q_half_sitting))
    sent_scene.sent.clear()
    drawing.place(placements(robot, robot.q_half_sitting))
    assert sent_scene.sent == []
    drawing.place(placements(robot, bent(robot, 2, 0.1)))
    assert sent_scene.sent == ["SetOrientationMessage"]
    sent_scene.sent.clear()
    moved = bent(robot, 2, 0.1)
    moved[0] += 0.05
    drawing.place(placements(robot, moved))
    assert sent_scene.sent == ["SetPositionMessage"]


def test_the_nodes_make_up_the_places_of_all_joints(sent_scene: SimpleNamespace) -> None:
    robot, drawing = sent_scene.robot, sent_scene.drawing
    rng = np.random.default_rng(8)
    for _ in range(3):
        q = pin.integrate(robot.model, robot.q_half_sitting, rng.normal(scale=0.4, size=robot.nv))
        there = placements(robot, q)
        drawing.place(there)
        for joint, node in drawing._nodes.items():
            above = drawing._above[joint]
            wanted = there[joint].homogeneous
            found = pin.XYZQUATToSE3(in_the_world(drawing, joint)).homogeneous
            assert np.allclose(found, wanted, atol=2e-4)
            assert above is None or node.name.startswith(drawing._nodes[above].name + "/")


def test_the_ghost_is_drawn_where_it_comes_out(sent_scene: SimpleNamespace) -> None:
    robot, ghost = sent_scene.robot, sent_scene.ghost
    q = robot.q_half_sitting.copy()
    there = placements(robot, q)
    ghost.place(q, there)
    assert not ghost.drawn
    assert ghost._drawing is None  # nothing of it was sent to a page
    ghost.place(bent(robot, 0, 0.2), there)
    assert ghost.drawn
    assert ghost._drawing._top.visible
    ghost.place(q, there)
    assert not ghost._drawing._top.visible
    sent_scene.drawing.set_opacity(0.5)
    ghost.reconsider()
    assert ghost._drawing._top.visible  # it shows through
    ghost.set_visible(False)
    assert not ghost._drawing._top.visible
    ghost.set_visible(True)
    sent_scene.drawing.set_opacity(1.0)
    sent_scene.drawing.set_visible(False)
    ghost.reconsider()
    assert ghost._drawing._top.visible  # nothing covers it


def test_no_corner_moves_further_than_the_bound(sent_scene: SimpleNamespace) -> None:
    rng = np.random.default_rng(9)
    for part in sent_scene.parts[::5]:
        corners = part.mesh.vertices
        reach = float(np.linalg.norm(corners, axis=1).max())
        for size in (1e-3, 0.1, 2.0):
            T_one, T_other = pin.SE3.Random(), pin.exp6(size * rng.normal(size=6))
            T_other = T_one * T_other
            apart = np.linalg.norm(
                (corners @ T_one.rotation.T + T_one.translation)
                - (corners @ T_other.rotation.T + T_other.translation),
                axis=1,
            )
            assert apart.max() <= farthest(T_one, T_other, reach) + 1e-12
    same = pin.SE3.Random()
    assert farthest(same, same, 1.0) < INSET
