"""Pictures of a scene: sun, sky, soft shadows and a floor with a grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from equipoise.analysis.rendering.camera import Camera
from equipoise.analysis.rendering.raster import Raster, rasterise, weights
from equipoise.analysis.rendering.scene_meshes import Picture
from equipoise.spatial import Array


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
    floor = _floor(camera, width, height, sun, light)
    image = np.repeat(np.repeat(floor, smooth, axis=0), smooth, axis=1)[:, :, None] * np.ones(3)
    _paint_bodies(image, raster, corners, picture, camera, sun, light)
    _paint_outlines(image, raster, picture)
    return image.reshape(height, smooth, width, smooth, 3).mean(axis=(1, 3))


def _in_pixels(projected: Array, camera: Camera, width: int, height: int) -> Array:
    x_min, x_max, y_min, y_max = camera.window
    pixels = projected.copy()
    pixels[:, 0] = (projected[:, 0] - x_min) / (x_max - x_min) * width
    pixels[:, 1] = (y_max - projected[:, 1]) / (y_max - y_min) * height
    return pixels


def _in_metres(columns: Array, rows: Array, camera: Camera, shape: tuple) -> tuple[Array, Array]:
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
        under = (at[:, :2] > 0.0).all(axis=1) & (at[:, :2] < self.size).all(axis=1)
        at = at[under]
        lit = np.zeros(len(at), dtype=np.int64)
        window = self.view.window
        per_metre = self.size / np.array([window[1] - window[0], window[3] - window[2]])
        for offset in _DISC * self.blur:
            column, row = (at[:, :2] + offset * per_metre).T.astype(np.int64)
            np.clip(column, 0, self.size - 1, out=column)
            np.clip(row, 0, self.size - 1, out=row)
            slack = (0.006 + np.hypot(*offset)) / self.view.distance
            lit += self.depths.take(row * self.size + column) <= at[:, 2] + slack
        share[under] = lit / len(_DISC)
        return share


def _disc(count: int) -> Array:
    """Return points (count, 2) spread evenly over the unit disc."""
    k = np.arange(count) + 0.5
    radius, angle = np.sqrt(k / count), np.pi * (3.0 - np.sqrt(5.0)) * k
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


_DISC = _disc(14)


def _floor(camera: Camera, width: int, height: int, sun: _Sun, light: Light) -> Array:
    """Return the brightness (height, width) of the floor z = 0, which fades into white."""
    rows, columns = np.divmod(np.arange(width * height), width)
    origin, direction = camera.rays(*_in_metres(columns, rows, camera, (height, width)))
    steep = np.minimum(direction[:, 2], -1e-9)
    along = -origin[:, 2] / steep
    points = origin[:, :2] + along[:, None] * direction[:, :2]
    fade = np.exp(-((np.linalg.norm(points - camera.target[:2], axis=1) / light.fade) ** 4))
    fade *= (along > 0.0) * _vignette(width, height).ravel()
    shade = np.ones(width * height)
    seen = np.flatnonzero(fade > 0.004)
    on_floor = np.column_stack([points[seen], np.zeros(len(seen))])
    shade[seen] -= fade[seen] * light.floor_shadow * (1.0 - sun.reaches(on_floor))
    lines = _grid_lines(points.reshape(height, width, 2), light)
    return shade.reshape(height, width) - light.grid_strength * fade.reshape(height, width) * lines


def _grid_lines(points: Array, light: Light) -> Array:
    """Return the share (h, w) of each pixel's floor that grid lines cover."""
    steps = [np.gradient(points, axis=axis) for axis in (0, 1)]
    footprint = np.maximum(np.abs(steps[0]) + np.abs(steps[1]), 1e-9)
    offset = np.abs((points / light.grid + 0.5) % 1.0 - 0.5) * light.grid
    covered = (light.grid_line + 0.5 * footprint - offset) / footprint
    most = 2.0 * light.grid_line / footprint
    return np.minimum(np.clip(covered, 0.0, 1.0), np.minimum(most, 1.0)).max(axis=2)


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
    rows, columns = np.nonzero(raster.triangle >= 0)
    seen = raster.triangle[rows, columns]
    x, y = _in_metres(columns, rows, camera, raster.triangle.shape)
    points = camera.unproject(np.column_stack([x, y, raster.nearness[rows, columns]]))
    share = weights(corners[seen], columns, rows)
    normals = np.einsum("nk,nkj->nj", share, picture.mesh.normals[picture.mesh.triangles[seen]])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    _, direction = camera.rays(x, y)
    direction = direction / np.linalg.norm(direction, axis=1, keepdims=True)
    facing = np.einsum("ij,ij->i", normals, direction)
    normals = np.where((facing > 0.0)[:, None], -normals, normals)
    falling = np.maximum(normals @ sun.direction, 0.0) * sun.reaches(points + 0.004 * normals)
    above = 0.5 + 0.5 * normals[:, 2]
    received = light.sun * falling + light.sky * above + light.ground
    halfway = sun.direction - direction
    halfway /= np.linalg.norm(halfway, axis=1, keepdims=True)
    gloss = np.maximum(np.einsum("ij,ij->i", normals, halfway), 0.0) ** 40 * (falling > 0.0)
    linear = picture.rgb[picture.part[seen]] ** 2.2 * received[:, None] + 0.05 * gloss[:, None]
    image[rows, columns] = np.clip(linear, 0.0, 1.0) ** (1.0 / 2.2)


def _paint_outlines(image: Array, raster: Raster, picture: Picture) -> None:
    """Darken where one part ends before another, so that light parts stand out from white."""
    part = np.where(raster.triangle < 0, -1, np.append(picture.part, -1)[raster.triangle])
    edge = np.zeros(part.shape, dtype=bool)
    across, down = part[:, 1:] != part[:, :-1], part[1:] != part[:-1]
    edge[:, 1:] |= across
    edge[:, :-1] |= across
    edge[1:] |= down
    edge[:-1] |= down
    image[edge & (part >= 0)] *= 0.62
