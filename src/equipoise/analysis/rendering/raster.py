"""Which triangle is seen in each pixel, and where on it: a depth buffer.

A depth buffer, not a painter's sort: the links of a robot reach into each other, and sorted
triangles of shapes that intersect cannot be drawn right in any order.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from equipoise.compiled.compilation import compiled, entrance
from equipoise.compiled.scratch import scratch_matrix
from equipoise.spatial import Array, Indices

FLAT = 1e-9  # [pixel^2]
LEVEL = 1e-12  # [1/pixel]


@dataclass(frozen=True)
class Raster:
    """What each pixel (row 0 on top) sees.

    `triangle` (h, w): index of the nearest triangle, -1 where there is none. `nearness` (h, w):
    its nearness there, -inf where there is none.
    """

    triangle: Indices
    nearness: Array


def rasterise(corners: Array, width: int, height: int) -> Raster:
    """Return what is seen of triangles (m, 3, 3) given in pixels: column, row, nearness.

    The centre of the pixel in row r and column c is at (c + 0.5, r + 0.5). Triangles with a
    corner that is not finite are left out.
    """
    raster = blank_raster(height, width)
    draw_into(raster, corners)
    return raster


def blank_raster(height: int, width: int) -> Raster:
    """Return a raster that sees nothing yet."""
    return Raster(np.full((height, width), -1), np.full((height, width), -np.inf))


def draw_into(raster: Raster, corners: Array) -> None:
    """Let a raster see these triangles (m, 3, 3), as `rasterise` takes them, and nothing else."""
    raster.nearness[:], raster.triangle[:] = -np.inf, -1
    draw_triangles(np.ascontiguousarray(corners), raster.nearness, raster.triangle)


def weights(corners: Array, column: Indices, row: Indices) -> Array:
    """Return the weight (n, 3) of each corner of triangles (n, 3, 3) at pixels (n,)."""
    x, y = column + 0.5, row + 0.5
    a, b, c = corners[:, 0, :2], corners[:, 1, :2], corners[:, 2, :2]
    area = _cross(b - a, c - a)
    point = np.column_stack([x, y])
    second = _cross(point - a, c - a) / area
    third = _cross(b - a, point - a) / area
    return np.column_stack([1.0 - second - third, second, third])


def _cross(u: Array, v: Array) -> Array:
    return u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]


@entrance
def draw_triangles(corners: np.ndarray, nearness: np.ndarray, triangle: np.ndarray) -> None:
    """Write the nearest of triangles [m, 3, 3], and how near it is, to each pixel [h, w]."""
    height = nearness.shape[0]
    edges = scratch_matrix(4, 3)
    for k in range(corners.shape[0]):
        if not set_edges(corners[k], edges):
            continue
        a, b, c = corners[k, 0, 1], corners[k, 1, 1], corners[k, 2, 1]
        low, high = max(min(a, b, c), -1.0), min(max(a, b, c), height + 1.0)
        for row in range(max(math.ceil(low - 0.5), 0), min(math.floor(high - 0.5) + 1, height)):
            draw_span(edges, row, k, nearness[row], triangle[row])


@compiled
def set_edges(p: np.ndarray, edges: np.ndarray) -> bool:
    """Write the edge functions of a triangle [3, 3] and, last, its nearness as a plane.

    Each row (s, t, u) [4, 3] stands for s x + t y + u; an edge function is 0 on its edge and 1 in
    the corner opposite. Tell whether it can be drawn.
    """
    total = 0.0
    for i in range(3):
        total += abs(p[i, 0]) + abs(p[i, 1]) + abs(p[i, 2])
    area = (p[1, 0] - p[0, 0]) * (p[2, 1] - p[0, 1]) - (p[1, 1] - p[0, 1]) * (p[2, 0] - p[0, 0])
    if not (total < np.inf and abs(area) > FLAT):
        return False
    for j in range(3):
        edges[3, j] = 0.0
    for i in range(3):
        a, b = (i + 1) % 3, (i + 2) % 3
        edges[i, 0] = (p[a, 1] - p[b, 1]) / area
        edges[i, 1] = (p[b, 0] - p[a, 0]) / area
        edges[i, 2] = (p[a, 0] * p[b, 1] - p[b, 0] * p[a, 1]) / area
        for j in range(3):
            edges[3, j] += p[i, 2] * edges[i, j]
    return True


@compiled
def draw_span(
    edges: np.ndarray, row: int, k: int, nearness: np.ndarray, triangle: np.ndarray
) -> None:
    """Write triangle k to the pixels of a row [w] in which it is the nearest."""
    width, y = nearness.shape[0], row + 0.5
    low, high = -1.0, width + 1.0
    for i in range(3):
        slope, level = edges[i, 0], edges[i, 1] * y + edges[i, 2]
        if slope > LEVEL:
            low = max(low, -level / slope)
        elif slope < -LEVEL:
            high = min(high, -level / slope)
        elif level < 0.0:
            return
    first, last = max(math.ceil(low - 0.5), 0), min(math.floor(high - 0.5), width - 1)
    slope, level = edges[3, 0], edges[3, 1] * y + edges[3, 2]
    for column in range(first, last + 1):
        value = slope * (column + 0.5) + level
        if value >= nearness[column]:
            nearness[column] = value
            triangle[column] = k
