"""Kernels that colour pixels: what a ray meets, how light falls on it, and the mean of samples."""

from __future__ import annotations

import math

import numpy as np

from equipoise.compiled.compilation import compiled, entrance
from equipoise.compiled.scratch import scratch

GLOSS = 0.05
OUTLINE = 0.62
STEEP = -1e-9
OFF = 0.004  # [m] above its face that a point is when it looks for the sun
OUTERMOST = 5  # samples on the rim of the disc
SEEN = 0.0012  # of a shadow that can be seen


@entrance
def paint_bodies(
    triangle: np.ndarray,
    nearness: np.ndarray,
    corners: np.ndarray,
    normals: np.ndarray,
    colours: np.ndarray,
    view: np.ndarray,
    lights: np.ndarray,
    depths: np.ndarray,
    samples: np.ndarray,
    brightness: np.ndarray,
    image: np.ndarray,
) -> None:
    """Write the colour of every pixel that sees a triangle to the image [h, w, 3].

    `triangle`, `nearness` [h, w] are those of a raster; `corners`, `normals` [m, 3, 3] those of the
    triangles, in pixels and in the world, `colours` [m, 3] theirs. `view` [6, 3]: the eye, the ray
    through pixel (0, 0) as far as the picture plane, what a row and what a column adds to it, the
    way from the eye straight to that plane, and whether it is a perspective. `lights`, `depths` and
    `samples`: see `lit_share`. `brightness` [k] is what is shown for light from 0 to 1.
    """
    ray, n, p, half = scratch(3), scratch(3), scratch(3), scratch(3)
    shades, perspective = brightness.shape[0] - 1, view[5, 0] > 0.0
    sun, light = lights[0], lights[1]
    for row in range(triangle.shape[0]):
        for column in range(triangle.shape[1]):
            k, near = triangle[row, column], nearness[row, column]
            if k < 0:
                continue
            for j in range(3):
                across = view[1, j] + row * view[2, j] + column * view[3, j]
                if perspective:
                    ray[j], p[j] = across, view[0, j] + across / near
                else:
                    ray[j] = view[4, j]
                    p[j] = view[0, j] + across - (1.0 + near) * view[4, j]
            mix_normals(corners[k], normals[k], column + 0.5, row + 0.5, n)
            to_unit(ray)
            if ray[0] * n[0] + ray[1] * n[1] + ray[2] * n[2] > 0.0:
                for j in range(3):
                    n[j] = -n[j]
            falling = n[0] * sun[0] + n[1] * sun[1] + n[2] * sun[2]
            if falling > 0.0:
                for j in range(3):
                    p[j] += OFF * n[j]
                falling *= lit_share(p, lights, depths, samples)
            falling = max(falling, 0.0)
            received = light[0] * falling + light[1] * (0.5 + 0.5 * n[2]) + light[2]
            gloss = 0.0
            if falling > 0.0:
                for j in range(3):
                    half[j] = sun[j] - ray[j]
                to_unit(half)
                mirrored = max(n[0] * half[0] + n[1] * half[1] + n[2] * half[2], 0.0) ** 8
                gloss = GLOSS * mirrored * mirrored**4
            for j in range(3):
                linear = colours[k, j] * received + gloss
                image[row, column, j] = brightness[int(min(max(linear, 0.0), 1.0) * shades + 0.5)]


@compiled
def lit_share(p: np.ndarray, lights: np.ndarray, depths: np.ndarray, samples: np.ndarray) -> float:
    """Return the share of the samples around a world point p [3] that nothing is nearer to the sun.

    `lights` [5, 4]: the way to the sun; the light of sun, sky and ground; and the map from points
    to pixels of `depths` [h, w] and nearness. `samples` [k, 3]: offsets in pixels, and how much
    nearer something must be, the outermost last. What lies outside of the map is lit.
    """
    height, width = depths.shape
    x = lights[2, 0] * p[0] + lights[2, 1] * p[1] + lights[2, 2] * p[2] + lights[2, 3]
    y = lights[3, 0] * p[0] + lights[3, 1] * p[1] + lights[3, 2] * p[2] + lights[3, 3]
    if not (0.0 < x < width and 0.0 < y < height):
        return 1.0
    near = lights[4, 0] * p[0] + lights[4, 1] * p[1] + lights[4, 2] * p[2] + lights[4, 3]
    count = samples.shape[0]
    outer = count - OUTERMOST
    lit = count_lit(x, y, near, depths, samples, outer, count)
    if lit == 0 or lit == OUTERMOST:  # where all around is alike, so is what is within
        return lit / OUTERMOST
    return (lit + count_lit(x, y, near, depths, samples, 0, outer)) / count


@compiled
def count_lit(
    x: float, y: float, near: float, depths: np.ndarray, samples: np.ndarray, first: int, end: int
) -> int:
    """Return of how many samples first..end around a pixel nothing is nearer to the sun."""
    height, width = depths.shape
    lit = 0
    for k in range(first, end):
        column = min(max(int(x + samples[k, 0]), 0), width - 1)
        row = min(max(int(y + samples[k, 1]), 0), height - 1)
        if depths[row, column] <= near + samples[k, 2]:
            lit += 1
    return lit


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
    target: np.ndarray,
    reach: float,
    points: np.ndarray,
    fade: np.ndarray,
) -> None:
    """Write where the ray of each pixel meets z = 0, points [h, w, 2], and what is left there.

    The floor fades [h, w] with the distance from the camera's target, at `reach` [m] to 1 / e.
    """
    origin, ray, perspective = scratch(3), scratch(3), view[5, 0] > 0.0
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
def paint_grid(
    points: np.ndarray,
    fade: np.ndarray,
    lines: np.ndarray,
    backdrop: np.ndarray,
    image: np.ndarray,
) -> None:
    """Write the floor at points [h, w, 2], with its grid, to the image [h, w, 3].

    `lines` [3]: spacing [m], half width [m] and strength of the grid. `backdrop` [h + 1, 3]: the
    colour behind each row, and last that of the floor, into which it goes over as the floor
    `fade`s.
    """
    height, width = fade.shape
    for row in range(height):
        for column in range(width):
            covered, left = 0.0, fade[row, column]
            for i in range(2):
                step = abs(points[min(row + 1, height - 1), column, i] - points[row, column, i])
                step += abs(points[row, min(column + 1, width - 1), i] - points[row, column, i])
                covered = max(covered, covered_by_line(points[row, column, i], step, lines))
            shade = 1.0 - lines[2] * left * covered
            for j in range(3):
                behind = backdrop[row, j]
                image[row, column, j] = shade * (behind + left * (backdrop[height, j] - behind))


@compiled
def covered_by_line(x: float, step: float, lines: np.ndarray) -> float:
    """Return the share of a pixel at x [m], `step` [m] wide, that lines across x cover."""
    footprint = max(step, 1e-9)
    offset = abs((x / lines[0] + 0.5) % 1.0 - 0.5) * lines[0]
    covered = min(max((lines[1] + 0.5 * footprint - offset) / footprint, 0.0), 1.0)
    return min(covered, 2.0 * lines[1] / footprint)


@entrance
def finish(
    triangle: np.ndarray,
    painted: np.ndarray,
    points: np.ndarray,
    strength: np.ndarray,
    lights: np.ndarray,
    depths: np.ndarray,
    samples: np.ndarray,
    image: np.ndarray,
) -> None:
    """Put the bodies on the floor: the image [h, w, 3] is of the floor, and becomes that of all.

    Shadows fall on the floor at points [h, w, 2] as strong as `strength` [h, w]. Of each pixel's
    k x k samples those that see a `triangle` [k h, k w] take what is `painted` [k h, k w, 3].
    """
    height, width = strength.shape
    k = triangle.shape[0] // height
    p = scratch(3)
    p[2] = 0.0
    for row in range(height):
        for column in range(width):
            seen = 0
            for a in range(k * row, k * row + k):
                for b in range(k * column, k * column + k):
                    if triangle[a, b] >= 0:
                        seen += 1
            shade = 1.0
            if seen < k * k and strength[row, column] > SEEN:
                p[0], p[1] = points[row, column, 0], points[row, column, 1]
                lit = lit_share(p, lights, depths, samples)
                shade = 1.0 - strength[row, column] * (1.0 - lit)
            for j in range(3):
                total = shade * image[row, column, j] * (k * k - seen)
                if seen > 0:
                    for a in range(k * row, k * row + k):
                        for b in range(k * column, k * column + k):
                            if triangle[a, b] >= 0:
                                total += painted[a, b, j]
                image[row, column, j] = total / (k * k)
