"""Pictures of a scene: sun, sky, soft shadows and a floor with a grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from equipoise.analysis.rendering.camera import Camera
from equipoise.analysis.rendering.raster import blank_raster, draw_into, rasterise
from equipoise.analysis.rendering.scene_meshes import Picture
from equipoise.analysis.rendering.shading import (
    draw_outlines,
    finish,
    meet_floor,
    paint_bodies,
    paint_grid,
)
from equipoise.spatial import Array, Indices

_GAMMA = 2.2
_BRIGHTNESS = np.linspace(0.0, 1.0, 1 << 16) ** (1.0 / _GAMMA)


@dataclass(frozen=True)
class Light:
    """Shares of the light, the shadow map's size [pixels] and the softness of shadows [m].

    `grid` is the spacing, `grid_line` half the width of a line, and `fade` the distance from the
    camera's target at which the floor ends [m], with `vignette` also at the picture's rim. The
    colours are those of the top of what is behind, of its foot, and of the floor.
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
    vignette: bool = True
    above: tuple[float, float, float] = (1.0, 1.0, 1.0)
    horizon: tuple[float, float, float] = (1.0, 1.0, 1.0)
    floor: tuple[float, float, float] = (1.0, 1.0, 1.0)


# the sky of films and of stills that stand alone: as in the viewer's page, light and without a rim
OUTDOORS = Light(
    fade=3.2,
    vignette=False,
    above=(0.80, 0.86, 0.92),
    horizon=(0.94, 0.95, 0.96),
    floor=(0.925, 0.93, 0.935),
)


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
    return Renderer(width, height, light=light, smooth=smooth).image(picture, camera)


class Renderer:
    """Draws pictures of one size; the floor is not drawn again while the camera stays."""

    def __init__(
        self, width: int, height: int, *, light: Light | None = None, smooth: int = 2
    ) -> None:
        self._light = light or Light()
        self._shape = height, width
        self._samples = height * smooth, width * smooth
        self._floor: _Floor | None = None
        # made once: new pages of memory cost as much as the drawing
        self._raster = blank_raster(*self._samples)
        self._painted = np.empty((*self._samples, 3))

    def image(self, picture: Picture, camera: Camera) -> Array:
        """Return the image (height, width, 3) in 0..1."""
        if self._floor is None or not self._floor.seen_by(camera):
            self._floor = _Floor(camera, self._shape, self._light)
        floor, (h, w) = self._floor, self._samples
        corners = _in_pixels(camera.project(picture.mesh.vertices), camera, w, h)
        corners = corners[picture.mesh.triangles]
        raster, painted = self._raster, self._painted
        draw_into(raster, corners)
        sun = _Sun(picture, camera, self._light)
        paint_bodies(
            raster.triangle,
            raster.nearness,
            corners,
            picture.mesh.normals[picture.mesh.triangles],
            picture.rgb[picture.part] ** _GAMMA,
            _view(camera, (h, w)),
            sun.lights,
            sun.depths,
            sun.samples,
            _BRIGHTNESS,
            painted,
        )
        draw_outlines(raster.triangle, picture.part, painted)
        image = floor.image.copy()
        finish(
            raster.triangle,
            painted,
            floor.points,
            floor.strength,
            sun.lights,
            sun.depths,
            sun.samples,
            image,
        )
        return image


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
    """Parallel light from above the camera's left shoulder, and what lies in shadow of it.

    `lights`, `depths` and `samples` are what `lit_share` is given.
    """

    def __init__(self, picture: Picture, camera: Camera, light: Light) -> None:
        right, _, forward = camera.axes
        towards = np.array([0.0, 0.0, 1.0]) - 0.30 * right - 0.70 * forward * [1.0, 1.0, 0.0]
        direction = towards / np.linalg.norm(towards)
        self.lights = np.zeros((5, 4))
        self.lights[0, :3] = direction
        self.lights[1, :3] = light.sun, light.sky, light.ground
        self.depths, self.samples = np.empty((0, 0)), np.empty((0, 3))
        vertices = picture.mesh.vertices
        if not len(vertices):
            return
        centre, size = vertices.mean(axis=0), light.shadow_map
        view = Camera(centre + 10.0 * direction, centre, perspective=False)
        view = view.fitted(vertices, margin=0.05)  # empty at its rim
        ends = np.vstack([np.zeros(3), np.eye(3)])
        origin, *axes = _in_pixels(view.project(ends), view, size, size)
        self.lights[2:5, :3] = np.column_stack([axis - origin for axis in axes])
        self.lights[2:5, 3] = origin
        pixels = vertices @ self.lights[2:5, :3].T + origin
        self.depths = rasterise(pixels[picture.mesh.triangles], size, size).nearness
        window = view.window
        per_metre = size / np.array([window[1] - window[0], window[3] - window[2]])
        offsets = _DISC * light.blur
        slack = (0.006 + np.hypot(*offsets.T)) / view.distance
        self.samples = np.column_stack([offsets * per_metre, slack])


def _disc(count: int) -> Array:
    """Return points (count, 2) spread evenly over the unit disc."""
    k = np.arange(count) + 0.5
    radius, angle = np.sqrt(k / count), np.pi * (3.0 - np.sqrt(5.0)) * k
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


_DISC = _disc(14)


class _Floor:
    """The floor z = 0 without shadows, which fades into what is behind, as a camera sees it.

    `points` (h, w, 2) [m] are where on it each pixel looks, `strength` (h, w) that of shadows.
    """

    def __init__(self, camera: Camera, shape: tuple[int, int], light: Light) -> None:
        self._camera = camera
        height, width = shape
        self.points, fade = np.empty((height, width, 2)), np.empty((height, width))
        meet_floor(_view(camera, shape), camera.target, light.fade, self.points, fade)
        if light.vignette:
            fade *= _vignette(width, height)
        down = np.linspace(0.0, 1.0, height)[:, None]
        behind = (1.0 - down) * np.array(light.above) + down * np.array(light.horizon)
        lines = np.array([light.grid, light.grid_line, light.grid_strength])
        self.image = np.empty((height, width, 3))
        paint_grid(self.points, fade, lines, np.vstack([behind, light.floor]), self.image)
        self.strength = light.floor_shadow * fade

    def seen_by(self, camera: Camera) -> bool:
        """Tell whether it is the same camera's."""
        mine = self._camera
        return (
            np.array_equal(mine.eye, camera.eye)
            and np.array_equal(mine.target, camera.target)
            and (mine.window, mine.perspective) == (camera.window, camera.perspective)
        )


def _vignette(width: int, height: int) -> Array:
    """Return a weight (height, width): 1 inside, falling to 0 at the rim of the picture."""
    across = np.minimum(np.arange(width) + 0.5, np.arange(width)[::-1] + 0.5) / (0.1 * width)
    down = np.minimum(np.arange(height) + 0.5, np.arange(height)[::-1] + 0.5) / (0.1 * height)
    ramp = np.clip(np.minimum(across[None, :], down[:, None]), 0.0, 1.0)
    return ramp * ramp * (3.0 - 2.0 * ramp)


def _view(camera: Camera, shape: tuple[int, int]) -> Array:
    """Return eye, first ray, step of a row, of a column, way to the picture plane, kind (6, 3)."""
    right, up, forward = camera.axes
    x, y = _in_metres(np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0]), camera, shape)
    straight = camera.distance * forward
    first = x[0] * right + y[0] * up + straight
    kind = np.full(3, float(camera.perspective))
    return np.array([camera.eye, first, (y[1] - y[0]) * up, (x[2] - x[0]) * right, straight, kind])
