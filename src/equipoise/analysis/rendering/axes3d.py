"""Drawing a scene into axes of a figure."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from equipoise.analysis.rendering.camera import Camera
from equipoise.analysis.rendering.render import render
from equipoise.analysis.rendering.scene_meshes import SceneMeshes
from equipoise.collision.scene import Scene
from equipoise.errors import NonFiniteError, ShapeError
from equipoise.spatial import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

AZIMUTH, ELEVATION, DISTANCE = np.radians(-70.0), np.radians(7.0), 5.0  # [rad, rad, m]
_REACH = 0.8  # [m] of what surrounds the robot that a picture shows


def draw_scene(
    ax: Axes, scene: Scene | SceneMeshes, q: Array, camera: Camera | None = None
) -> None:
    """Draw robot, world and held objects at configuration `q` (nq,) into axes.

    Without a camera, one is chosen that shows the whole robot. A `SceneMeshes` instead of the scene
    saves the tessellation where the same scene is drawn often.

    Raises: ShapeError, NonFiniteError for a `q` that is none.
    """
    scene_meshes = scene if isinstance(scene, SceneMeshes) else SceneMeshes(scene)
    q = check_configuration(scene_meshes, q)
    camera = camera or frame_scene(scene_meshes, [q])
    box = ax.get_window_extent()
    width = max(16, round(min(box.width, box.height * camera.aspect)))
    height = max(16, round(width / camera.aspect))
    image = render(scene_meshes.at(q), camera, width, height)
    ax.imshow(image, extent=camera.window, interpolation="antialiased", aspect="equal")
    ax.set_axis_off()


def frame_scene(scene_meshes: SceneMeshes, configurations: list[Array] | Array) -> Camera:
    """Return the camera, seen from the robot's front right, that shows it in all configurations.

    What stands still is shown as far as it is near the robot.
    """
    pictures = [scene_meshes.at(check_configuration(scene_meshes, q)) for q in configurations]
    moving, still = [], []
    for picture in pictures:
        moves = scene_meshes.moving[picture.part]
        moving.append(picture.mesh.vertices[np.unique(picture.mesh.triangles[moves])])
        still.append(picture.mesh.vertices[np.unique(picture.mesh.triangles[~moves])])
    robot = np.vstack(moving)
    low, high = robot.min(axis=0), robot.max(axis=0)
    near = np.clip(still[0], low - _REACH, high + _REACH)
    near[:, 2] = np.maximum(near[:, 2], min(0.0, low[2]))
    points = np.vstack([robot, near])
    centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
    distance = max(DISTANCE, 3.0 * float(np.ptp(points, axis=0).max()))
    return Camera.around(centre, AZIMUTH, ELEVATION, distance).fitted(points)


def check_configuration(scene_meshes: SceneMeshes, q: Array) -> Array:
    """Return `q` (nq,) as an array. Raises: ShapeError, NonFiniteError."""
    values = np.array(q, dtype=float)
    if values.shape != (scene_meshes.model.nq,):
        raise ShapeError("q", values.shape, (scene_meshes.model.nq,))
    if not np.isfinite(values).all():
        raise NonFiniteError("A configuration to draw must be finite", given=values.tolist())
    return values
