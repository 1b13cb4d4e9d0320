"""Pictures of a scene: sun, sky, soft shadows and a floor with a grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from equipoise.analysis.rendering.camera import Camera
from equipoise.analysis.rendering.raster import Raster, rasterise
from equipoise.analysis.rendering.scene_meshes import Picture
from equipoise.analysis.rendering.shading import (
    draw_outlines,
    look,
    meet_floor,
    paint_floor,
    reduce_samples,
    shade,
)
from equipoise.compiled.compilation import entrance
from equipoise.spatial import Array, Indices

_GAMMA = 2.2
_BRIGHTNESS = np.linspace(0.0, 1.0, 1 << 16) ** (1.0 / _GAMMA)


@dataclass(frozen=True)
class Light:
    """Shares of the light, the shadow map's size [pixels] and the softness of shadows [m].

    `grid` is the spacing, `grid_line` half the width of a line, and `fade` the distance from the
    camera's target at which the floor ends [m].
    """

    sun: float = 0.62
    sky: float = 0.40
    ground: float = 0.22
    shadow_map: int = 700
    blur: float = 0.022
    floor_shadow: float = 0.30
    grid: float = 0.25
    grid_line: float = 0.003
    grid_strength: float = 0.10
    fade: float = 1.8


def render(
    picture: Picture,
    camera: Camera,
    width: int,
    height: int,
    *,
    light: Light | None = None,
    smooth: int = 2,
) -> Array:
    """Return the image (height, width, 3) in 0..1, white where there is nothing.

    Each pixel is the mean of `smooth` x `smooth` samples.
    """
    light = light or Light()
    w, h = width * smooth, height * smooth
    corners = _in_pixels(camera.project(picture.mesh.vertices), camera, w, h)
    corners = corners[picture.mesh.triangles]
    raster = rasterise(corners, w, h)
    sun = _Sun(picture, camera, light)
    image = np.empty((h, w, 3))
    _floor(camera, width, height, sun, light, image)
    _paint_bodies(image, raster, corners, picture, camera, sun, light)
    draw_outlines(raster.triangle, picture.part, image)
    small = np.empty((height, width, 3))
    reduce_samples(image, small)
    return small


def _in_pixels(projected: Array, camera: Camera, width: int, height: int) -> Array:
    x_min, x_max, y_min, y_max = camera.window
    pixels = projected.copy()
    pixels[:, 0] = (projected[:, 0] - x_min) / (x_max - x_min) * width
    pixels[:, 1] = (y_max - projected[:, 1]) / (y_max - y_min) * height
    return pixels


def _in_metres(
    columns: Indices, rows: Indices, camera: Camera, shape: tuple[int, ...]
) -> tuple[Array, Array]:
    x_min, x_max, y_min, y_max = camera.window
    x = x_min + (columns + 0.5) / shape[1] * (x_max - x_min)
    return x, y_max - (rows + 0.5) / shape[0] * (y_max - y_min)


class _Sun:
    """Parallel light from above the camera's left shoulder, and what lies in shadow of it."""

    def __init__(self, picture: Picture, camera: Camera, light: Light) -> None:
        right, _, forward = camera.axes
        towards = np.array([0.0, 0.0, 1.0]) - 0.30 * right - 0.70 * forward * [1.0, 1.0, 0.0]
        self.direction = towards / np.linalg.norm(towards)
        self.blur = light.blur
        self.size = light.shadow_map
        vertices = picture.mesh.vertices
        if not len(vertices):
            self.depths = None
            return
        centre = vertices.mean(axis=0)
        view = Camera(centre + 10.0 * self.direction, centre, perspective=False)
        self.view = view.fitted(vertices, margin=0.05)  # empty at its rim
        pixels = _in_pixels(self.view.project(vertices), self.view, self.size, self.size)
        self.depths = rasterise(pixels[picture.mesh.triangles], self.size, self.size).nearness

    def reaches(self, points: Array) -> Array:
        """Return the share (n,) of the sun that reaches world points (n, 3)."""
        share = np.ones(len(points))
        if self.depths is None:
            return share
        at = _in_pixels(self.view.project(points), self.view, self.size, self.size)
        window = self.view.window
        per_metre = self.size / np.array([window[1] - window[0], window[3] - window[2]])
        offsets = _DISC * self.blur
        slack = (0.006 + np.hypot(*offsets.T)) / self.view.distance
        lit_share(at, self.depths, offsets * per_metre, slack, share)
        return share


@entrance
def lit_share(
    at: np.ndarray, depths: np.ndarray, offsets: np.ndarray, slack: np.ndarray, share: np.ndarray
) -> None:
    """Write the share [n] of the samples around each point at [n, 3] that nothing is nearer than.

    Points and the samples' `offsets` [k, 2] are in pixels of the map `depths` [h, w]; a point
    outside it keeps its share.
    """
    height, width = depths.shape
    for i in range(at.shape[0]):
        x, y = at[i, 0], at[i, 1]
        if not (0.0 < x < width and 0.0 < y < height):
            continue
        lit = 0
        for k in range(offsets.shape[0]):
            column = min(max(int(x + offsets[k, 0]), 0), width - 1)
            row = min(max(int(y + offsets[k, 1]), 0), height - 1)
            lit += depths[row, column] <= at[i, 2] + slack[k]
        share[i] = lit / offsets.shape[0]


def _disc(count: int) -> Array:
    """Return points (count, 2) spread evenly over the unit disc."""
    k = np.arange(count) + 0.5
    radius, angle = np.sqrt(k / count), np.pi * (3.0 - np.sqrt(5.0)) * k
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


_DISC = _disc(14)


def _floor(camera: Camera, width: int, height: int, sun: _Sun, light: Light, image: Array) -> None:
    """Paint the floor z = 0, which fades into white, into every sample of the image."""
    points, fade = np.empty((height, width, 2)), np.empty((height, width))
    view = _view(camera, (height, width))
    meet_floor(view, camera.perspective, camera.target, light.fade, points, fade)
    fade *= _vignette(width, height)
    seen = fade > 0.004
    reached = np.ones((height, width))
    on_floor = points[seen]
    reached[seen] = sun.reaches(np.column_stack([on_floor, np.zeros(len(on_floor))]))
    lines = np.array([light.grid, light.grid_line, light.grid_strength, light.floor_shadow])
    paint_floor(points, fade, reached, lines, image)


def _vignette(width: int, height: int) -> Array:
    """Return a weight (height, width): 1 inside, falling to 0 at the rim of the picture."""
    across = np.minimum(np.arange(width) + 0.5, np.arange(width)[::-1] + 0.5) / (0.1 * width)
    down = np.minimum(np.arange(height) + 0.5, np.arange(height)[::-1] + 0.5) / (0.1 * height)
    ramp = np.clip(np.minimum(across[None, :], down[:, None]), 0.0, 1.0)
    return ramp * ramp * (3.0 - 2.0 * ramp)


def _paint_bodies(
    image: Array,
    raster: Raster,
    corners: Array,
    picture: Picture,
    camera: Camera,
    sun: _Sun,
    light: Light,
) -> None:
    pixels = np.argwhere(raster.triangle >= 0)
    seen = np.empty((len(pixels), 9))
    look(
        pixels,
        raster.triangle,
        raster.nearness,
        corners,
        picture.mesh.normals[picture.mesh.triangles],
        _view(camera, raster.triangle.shape),
        camera.perspective,
        seen,
    )
    reached = np.zeros(len(pixels))
    facing = seen[:, 3:6] @ sun.direction > 0.0
    reached[facing] = sun.reaches(seen[facing, :3] + 0.004 * seen[facing, 3:6])
    colours = picture.rgb[picture.part] ** _GAMMA
    lights = np.array([sun.direction, [light.sun, light.sky, light.ground]])
    shade(pixels, raster.triangle, seen, reached, colours, lights, _BRIGHTNESS, image)


def _view(camera: Camera, shape: tuple[int, int]) -> Array:
    """Return eye, first ray, step of a row, of a column, and way to the picture plane (5, 3)."""
    right, up, forward = camera.axes
    x, y = _in_metres(np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0]), camera, shape)
    straight = camera.distance * forward
    first = x[0] * right + y[0] * up + straight
    return np.array([camera.eye, first, (y[1] - y[0]) * up, (x[2] - x[0]) * right, straight])
