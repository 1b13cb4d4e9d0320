"""Strips of snapshots of a scenario."""

from __future__ import annotations

import numpy as np
import pytest
from figure_runs import made_run, tray_places

from equipoise.analysis.figures.snapshots import snapshot_strip
from equipoise.analysis.figures.style import new_figure
from equipoise.analysis.rendering.axes3d import draw_scene, frame_scene
from equipoise.analysis.rendering.scene_meshes import SceneMeshes, robot_parts
from equipoise.analysis.rendering.stands import stands
from equipoise.errors import InputError, NonFiniteError, ShapeError


@pytest.fixture(scope="module")
def scene_meshes() -> SceneMeshes:
    return SceneMeshes(tray_places().scene)


def captions(figure) -> list[str]:
    return [text.get_text() for axes in figure.axes for text in axes.texts]


def test_stage_holds_every_shape_of_robot_and_world(scene_meshes):
    setup = tray_places()
    world = sum(len(body.shapes) for body in setup.scene.bodies)
    posts = len(stands(setup.scene))
    assert len(scene_meshes.parts) == len(robot_parts(setup.robot)) + world + posts
    collides = {shape.parentJoint for shape in setup.robot.collision_model.geometryObjects}
    assert collides <= {part.joint for part in robot_parts(setup.robot)}


def test_still_things_stay_and_the_tray_moves_with_its_hand(scene_meshes):
    robot = tray_places().robot
    q = robot.q_half_sitting.copy()
    before = scene_meshes.at(q)
    q[7 + robot.joint_index("LARM_JOINT6")] += 0.0
    q[7 + robot.joint_index("LARM_JOINT3")] += 0.3
    after = scene_meshes.at(q)
    shift = np.linalg.norm(after.mesh.vertices - before.mesh.vertices, axis=1)
    of_part = [
        shift[np.unique(before.mesh.triangles[before.part == k])].max()
        for k in range(len(scene_meshes.parts))
    ]
    still = [
        move for part, move in zip(scene_meshes.parts, of_part, strict=True) if part.joint == 0
    ]
    assert still == [0.0] * 3  # the desk's
    hand = robot.model.frames[robot.frame_id("left_palm")].parentJoint
    carried = [m for p, m in zip(scene_meshes.parts, of_part, strict=True) if p.joint == hand]
    assert len(carried) >= 4  # the hand and the tray's three shapes
    assert min(carried) > 0.01


def test_the_camera_shows_the_whole_robot(scene_meshes):
    robot = tray_places().robot
    low = robot.q_half_sitting.copy()
    low[:3] += [0.3, 0.4, -0.1]
    camera = frame_scene(scene_meshes, [robot.q_half_sitting, low])
    x_min, x_max, y_min, y_max = camera.window
    for q in (robot.q_half_sitting, low):
        picture = scene_meshes.at(q)
        moving = np.unique(picture.mesh.triangles[scene_meshes.moving[picture.part]])
        x, y, _ = camera.project(picture.mesh.vertices[moving]).T
        assert x_min < x.min()
        assert x.max() < x_max
        assert y_min < y.min()
        assert y.max() < y_max


def test_drawing_shows_desk_and_tray_in_their_colours(scene_meshes):
    figure = new_figure(3.0, 3.0)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    draw_scene(axes, tray_places().scene, tray_places().robot.q_half_sitting)
    image = np.asarray(axes.images[0].get_array())
    red, green, blue = np.moveaxis(image, 2, 0)
    assert (blue > 1.8 * red).sum() > 20  # blue tray
    assert ((red > 1.3 * blue) & (green > 1.1 * blue)).sum() > 500  # wooden desk
    assert (image.max(axis=2) < 0.25).sum() > 100  # dark joints and shoes


def test_strip_shows_the_wanted_times():
    run = made_run(3000)
    figure = snapshot_strip(run, times=[0.5, 1.2503, 99.0], setup=tray_places())
    assert captions(figure) == ["t = 0.50 s", "t = 1.25 s", "t = 3.00 s"]
    figure = snapshot_strip(run)
    assert len(figure.axes) == 6
    assert captions(figure)[0] == "t = 0.00 s"
    windows = {tuple(axes.images[0].get_extent()) for axes in figure.axes}
    assert len(windows) == 1  # the same camera


def test_one_tick_gives_one_snapshot():
    assert len(snapshot_strip(made_run(1), count=6, setup=tray_places()).axes) == 1


def test_snapshots_avoid_ticks_that_are_not_finite():
    run = made_run(50)
    run.arrays["q"][20:] = np.nan
    figure = snapshot_strip(run, count=3, setup=tray_places())
    assert captions(figure) == ["t = 0.00 s", "t = 0.01 s", "t = 0.02 s"]


def test_refusals_say_why(scene_meshes):
    setup = tray_places()
    with pytest.raises(InputError, match="without ticks"):
        snapshot_strip(made_run(0), setup=setup)
    with pytest.raises(InputError, match="at least one"):
        snapshot_strip(made_run(5), count=0, setup=setup)
    with pytest.raises(InputError, match="at least one"):
        snapshot_strip(made_run(5), times=[], setup=setup)
    axes = new_figure(2.0, 2.0).add_axes((0.0, 0.0, 1.0, 1.0))
    with pytest.raises(ShapeError):
        draw_scene(axes, scene_meshes, np.zeros(3))
    with pytest.raises(NonFiniteError):
        draw_scene(axes, scene_meshes, np.full(setup.robot.nq, np.nan))
