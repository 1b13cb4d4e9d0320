"""Kernels that colour pixels: what a ray meets, how light falls on it, and the mean of samples."""

from __future__ import annotations

import math

import numpy as np

from equipoise.compiled.compilation import compiled, entrance
from equipoise.compiled.scratch import scratch

GLOSS = 0.05
OUTLINE = 0.62
STEEP = -1e-9


@entrance
def look(
    pixels: np.ndarray,
    triangle: np.ndarray,
    nearness: np.ndarray,
    corners: np.ndarray,
    normals: np.ndarray,
    view: np.ndarray,
    perspective: bool,
    seen: np.ndarray,
) -> None:
    """Write to seen [n, 9] the point, the normal towards the eye and the ray of pixels [n, 2].

    `corners`, `normals` [m, 3, 3] are those of the triangles, in pixels and in the world; `view`
    [5, 3]: the eye, the ray through pixel (0, 0) as far as the picture plane, what a row and what a
    column adds to it, and the way from the eye straight to that plane.
    """
    ray, n = scratch(3), scratch(3)
    for i in range(pixels.shape[0]):
        row, column = pixels[i, 0], pixels[i, 1]
        k, near = triangle[row, column], nearness[row, column]
        for j in range(3):
            across = view[1, j] + row * view[2, j] + column * view[3, j]
            if perspective:
                ray[j], seen[i, j] = across, view[0, j] + across / near
            else:
                ray[j] = view[4, j]
                seen[i, j] = view[0, j] + across - (1.0 + near) * view[4, j]
        mix_normals(corners[k], normals[k], column + 0.5, row + 0.5, n)
        to_unit(ray)
        towards = ray[0] * n[0] + ray[1] * n[1] + ray[2] * n[2]
        for j in range(3):
            seen[i, 3 + j] = -n[j] if towards > 0.0 else n[j]
            seen[i, 6 + j] = ray[j]


@compiled
def mix_normals(p: np.ndarray, normals: np.ndarray, x: float, y: float, n: np.ndarray) -> None:
    """Write the unit normal n [3] at a pixel of a triangle [3, 3] from those of its corners."""
    ux, uy, vx, vy = p[1, 0] - p[0, 0], p[1, 1] - p[0, 1], p[2, 0] - p[0, 0], p[2, 1] - p[0, 1]
    area = ux * vy - uy * vx
    second = ((x - p[0, 0]) * vy - (y - p[0, 1]) * vx) / area
    third = (ux * (y - p[0, 1]) - uy * (x - p[0, 0])) / area
    for j in range(3):
        n[j] = (
            (1.0 - second - third) * normals[0, j] + second * normals[1, j] + third * normals[2, j]
        )
    to_unit(n)


@compiled
def to_unit(v: np.ndarray) -> None:
    """Scale v [3] to length 1."""
    length = max(math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]), 1e-12)
    for j in range(3):
        v[j] /= length


@entrance
def shade(
    pixels: np.ndarray,
    triangle: np.ndarray,
    seen: np.ndarray,
    reached: np.ndarray,
    colours: np.ndarray,
    lights: np.ndarray,
    brightness: np.ndarray,
    image: np.ndarray,
) -> None:
    """Write the colour of pixels [n, 2] to the image [h, w, 3].

    `seen` is as `look` writes it; `reached` [n] the share of the sun that arrives; `colours`
    [m, 3] those of the triangles; `lights` [2, 3] the way to the sun, and the light of sun, sky and
    ground; `brightness` [k] what is shown for light from 0 to 1.
    """
    half = scratch(3)
    sun, light, shades = lights[0], lights[1], brightness.shape[0] - 1
    for i in range(pixels.shape[0]):
        row, column = pixels[i, 0], pixels[i, 1]
        n, ray = seen[i, 3:6], seen[i, 6:9]
        falling = max(n[0] * sun[0] + n[1] * sun[1] + n[2] * sun[2], 0.0) * reached[i]
        received = light[0] * falling + light[1] * (0.5 + 0.5 * n[2]) + light[2]
        gloss = 0.0
        if falling > 0.0:
            for j in range(3):
                half[j] = sun[j] - ray[j]
            to_unit(half)
            mirrored = max(n[0] * half[0] + n[1] * half[1] + n[2] * half[2], 0.0) ** 8
            gloss = GLOSS * mirrored * mirrored**4
        for j in range(3):
            linear = colours[triangle[row, column], j] * received + gloss
            image[row, column, j] = brightness[int(min(max(linear, 0.0), 1.0) * shades + 0.5)]


@entrance
def draw_outlines(triangle: np.ndarray, part: np.ndarray, image: np.ndarray) -> None:
    """Darken where one part [m] ends before another, so that light parts stand out from white."""
    height, width = triangle.shape
    for row in range(height):
        for column in range(width):
            here = part_at(triangle, part, row, column)
            if here >= 0 and (
                here != part_at(triangle, part, max(row - 1, 0), column)
                or here != part_at(triangle, part, min(row + 1, height - 1), column)
                or here != part_at(triangle, part, row, max(column - 1, 0))
                or here != part_at(triangle, part, row, min(column + 1, width - 1))
            ):
                for j in range(3):
                    image[row, column, j] *= OUTLINE


@compiled
def part_at(triangle: np.ndarray, part: np.ndarray, row: int, column: int) -> int:
    """Return whose the triangle seen in a pixel is, -1 where there is none."""
    k = triangle[row, column]
    return part[k] if k >= 0 else -1


@entrance
def meet_floor(
    view: np.ndarray,
    perspective: bool,
    target: np.ndarray,
    reach: float,
    points: np.ndarray,
    fade: np.ndarray,
) -> None:
    """Write where the ray of each pixel meets z = 0, points [h, w, 2], and what is left there.

    The floor fades [h, w] with the distance from the camera's target, at `reach` [m] to 1 / e.
    """
    origin, ray = scratch(3), scratch(3)
    for row in range(fade.shape[0]):
        for column in range(fade.shape[1]):
            for j in range(3):
                across = view[1, j] + row * view[2, j] + column * view[3, j]
                origin[j], ray[j] = view[0, j], across
                if not perspective:
                    origin[j], ray[j] = view[0, j] + across - view[4, j], view[4, j]
            along = -origin[2] / min(ray[2], STEEP)
            x, y = origin[0] + along * ray[0], origin[1] + along * ray[1]
            points[row, column, 0], points[row, column, 1] = x, y
            far = math.sqrt((x - target[0]) ** 2 + (y - target[1]) ** 2) / reach
            fade[row, column] = math.exp(-(far**4)) if along > 0.0 else 0.0


@entrance
def paint_floor(
    points: np.ndarray,
    fade: np.ndarray,
    reached: np.ndarray,
    lines: np.ndarray,
    samples: np.ndarray,
) -> None:
    """Write the floor at points [h, w, 2], with its grid and shadows, to samples [k h, k w, 3].

    `lines` [4]: spacing [m] and half width [m] of the grid, strength of grid and shadows.
    """
    height, width = fade.shape
    k = samples.shape[0] // height
    for row in range(height):
        for column in range(width):
            shade = 1.0 - fade[row, column] * lines[3] * (1.0 - reached[row, column])
            covered = 0.0
            for i in range(2):
                step = abs(slope(points[:, column, i], row)) + abs(slope(points[row, :, i], column))
                covered = max(covered, covered_by_line(points[row, column, i], step, lines))
            shade -= lines[2] * fade[row, column] * covered
            for a in range(k * row, k * row + k):
                for b in range(k * column, k * column + k):
                    for j in range(3):
                        samples[a, b, j] = shade


@compiled
def slope(x: np.ndarray, i: int) -> float:
    """Return by how much x [n] grows from one to the next at i."""
    last = x.shape[0] - 1
    before, after = max(i - 1, 0), min(i + 1, last)
    return (x[after] - x[before]) / max(after - before, 1)


@compiled
def covered_by_line(x: float, step: float, lines: np.ndarray) -> float:
    """Return the share of a pixel at x [m], `step` [m] wide, that lines across x cover."""
    footprint = max(step, 1e-9)
    offset = abs((x / lines[0] + 0.5) % 1.0 - 0.5) * lines[0]
    covered = min(max((lines[1] + 0.5 * footprint - offset) / footprint, 0.0), 1.0)
    return min(covered, 2.0 * lines[1] / footprint)


@entrance
def reduce_samples(samples: np.ndarray, image: np.ndarray) -> None:
    """Write the mean of each square of samples [k h, k w, 3] to the image [h, w, 3]."""
    k = samples.shape[0] // image.shape[0]
    for row in range(image.shape[0]):
        for column in range(image.shape[1]):
            for j in range(3):
                total = 0.0
                for a in range(k * row, k * row + k):
                    for b in range(k * column, k * column + k):
                        total += samples[a, b, j]
                image[row, column, j] = total / (k * k)
