"""Configurations of a robot as a moving picture: for loops of one's own, which have no log."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from equipoise.analysis.rendering.camera import Camera
from equipoise.analysis.rendering.captions import write_caption
from equipoise.analysis.rendering.render import OUTDOORS, Renderer
from equipoise.analysis.rendering.scene_meshes import SceneMeshes
from equipoise.collision.scene import Body, Scene
from equipoise.errors import InputError
from equipoise.optional import require_package
from equipoise.robots import Robot
from equipoise.spatial import Array

AZIMUTH, ELEVATION, DISTANCE = np.radians(-40.0), np.radians(12.0), 5.0  # [rad, rad, m]
COLOURS = 128  # of an animated picture


def write_motion(
    robot: Robot,
    configurations: Sequence[Array] | Array,
    path: str | Path,
    *,
    bodies: Sequence[Body] = (),
    fps: float = 12.5,
    size: tuple[int, int] = (480, 400),
    caption: str = "",
) -> Path:
    """Write configurations (n, nq) as an animated GIF, or the last one as a PNG.

    `bodies` stand or are held around the robot; one camera sees all of it.
    Raises: InputError for configurations that are none, or another kind of file.
    """
    require_package("PIL", "plot", "a motion picture")
    from PIL import Image

    path = Path(path)
    if path.suffix.lower() not in (".gif", ".png"):
        raise InputError(
            "a motion is a GIF or a PNG", given=str(path), remedy="Let it end in .gif or .png"
        )
    all_q = np.atleast_2d(np.array(configurations, dtype=float))
    if all_q.ndim != 2 or all_q.shape[1] != robot.nq or not np.isfinite(all_q).all():
        raise InputError(f"configurations are rows of {robot.nq} finite numbers", given=all_q.shape)
    meshes = SceneMeshes(Scene(robot, bodies))
    pictures = (meshes.at(q) for q in (all_q if path.suffix.lower() == ".gif" else all_q[-1:]))
    camera = _camera(meshes, all_q, size[0] / size[1])
    renderer = Renderer(*size, light=OUTDOORS)
    frames = []
    for picture in pictures:
        image = np.clip(np.round(255.0 * renderer.image(picture, camera)), 0.0, 255.0)
        frame = image.astype(np.uint8)
        write_caption(frame, caption)
        frames.append(Image.fromarray(frame))
    if path.suffix.lower() == ".png":
        frames[0].save(path, optimize=True)
        return path
    few = [frame.quantize(COLOURS, dither=Image.Dither.NONE) for frame in frames]
    pause = round(1000.0 / fps)
    few[0].save(path, save_all=True, append_images=few[1:], duration=pause, loop=0, optimize=True)
    return path


def _camera(meshes: SceneMeshes, all_q: Array, aspect: float) -> Camera:
    """Return the camera that sees the whole scene in some of the configurations."""
    some = all_q[np.unique(np.linspace(0, len(all_q) - 1, 7).astype(int))]
    points = np.vstack([meshes.at(q).mesh.vertices[::5] for q in some])
    centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
    camera = Camera.around(centre, AZIMUTH, ELEVATION, DISTANCE).fitted(points, margin=0.08)
    x_min, x_max, y_min, y_max = camera.window
    width = max(x_max - x_min, (y_max - y_min) * aspect)
    height, x, y = width / aspect, 0.5 * (x_min + x_max), 0.5 * (y_min + y_max)
    window = (x - width / 2, x + width / 2, y - height / 2, y + height / 2)
    return replace(camera, window=window)
