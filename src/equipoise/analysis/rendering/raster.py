"""Which triangle is seen in each pixel, and where on it: a depth buffer in numpy.

A depth buffer, not a painter's sort: the links of a robot reach into each other, and sorted
triangles of shapes that intersect cannot be drawn right in any order.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from equipoise.spatial import Array

_FRAGMENTS_AT_ONCE = 2_000_000


@dataclass(frozen=True)
class Raster:
    """What each pixel (row 0 on top) sees.

    `triangle` (h, w): index of the nearest triangle, -1 where there is none. `nearness` (h, w):
    its nearness there, -inf where there is none.
    """

    triangle: Array
    nearness: Array


def rasterise(corners: Array, width: int, height: int) -> Raster:
    """Return what is seen of triangles (m, 3, 3) given in pixels: column, row, nearness.

    The centre of the pixel in row r and column c is at (c + 0.5, r + 0.5). Triangles with a
    corner that is not finite are left out.
    """
    nearness = np.full(width * height, -np.inf)
    triangle = np.full(width * height, -1)
    edges, plane, kept = _equations(corners)
    tri, row = _rows_of(corners[kept], height)
    first, last = _spans(edges, tri, row, width)
    counts = np.maximum(last - first + 1, 0)
    for part in _parts(counts):
        span = np.repeat(np.arange(part.start, part.stop), counts[part])
        start = np.cumsum(counts[part]) - counts[part]
        column = first[span] + np.arange(span.size) - np.repeat(start, counts[part])
        k = tri[span]
        pixel = row[span] * width + column
        value = plane[k, 0] * (column + 0.5) + plane[k, 1] * (row[span] + 0.5) + plane[k, 2]
        np.maximum.at(nearness, pixel, value)
        seen = value == nearness[pixel]
        triangle[pixel[seen]] = kept[k[seen]]
    shape = (height, width)
    return Raster(triangle.reshape(shape), nearness.reshape(shape))


def weights(corners: Array, column: Array, row: Array) -> Array:
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


def _equations(corners: Array) -> tuple[Array, Array, Array]:
    """Return edge functions (k, 3, 3), nearness planes (k, 3) and which triangles they are of."""
    with np.errstate(invalid="ignore"):
        area = _cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    kept = np.flatnonzero(np.isfinite(corners).all(axis=(1, 2)) & (np.abs(area) > 1e-9))
    p, area = corners[kept], area[kept]
    edges = np.empty((kept.size, 3, 3))
    for i in range(3):
        a, b = p[:, (i + 1) % 3], p[:, (i + 2) % 3]
        edges[:, i, 0] = (a[:, 1] - b[:, 1]) / area
        edges[:, i, 1] = (b[:, 0] - a[:, 0]) / area
        edges[:, i, 2] = (a[:, 0] * b[:, 1] - b[:, 0] * a[:, 1]) / area
    return edges, np.einsum("ki,kij->kj", p[:, :, 2], edges), kept


def _rows_of(corners: Array, height: int) -> tuple[Array, Array]:
    """Return every pair of a triangle and a pixel row whose centre line it may touch."""
    y = corners[:, :, 1]
    low = np.maximum(np.ceil(np.clip(y.min(axis=1), -1.0, height + 1.0) - 0.5), 0).astype(int)
    high = np.minimum(
        np.floor(np.clip(y.max(axis=1), -1.0, height + 1.0) - 0.5), height - 1
    ).astype(int)
    counts = np.maximum(high - low + 1, 0)
    tri = np.repeat(np.arange(len(corners)), counts)
    offset = np.arange(tri.size) - np.repeat(np.cumsum(counts) - counts, counts)
    return tri, low[tri] + offset


def _spans(edges: Array, tri: Array, row: Array, width: int) -> tuple[Array, Array]:
    """Return the first and last column inside the triangle on each row; last < first if none."""
    slope = edges[tri, :, 0]
    level = edges[tri, :, 1] * (row[:, None] + 0.5) + edges[tri, :, 2]
    flat = np.abs(slope) < 1e-12
    crossing = -level / np.where(flat, 1.0, slope)
    low = np.where(slope > 0.0, crossing, -np.inf)
    high = np.where(slope < 0.0, crossing, np.inf)
    low[flat], high[flat] = -np.inf, np.inf
    low, high = low.max(axis=1), high.min(axis=1)
    outside = (flat & (level < 0.0)).any(axis=1)
    first = np.ceil(np.clip(low, 0.0, width + 1.0) - 0.5).astype(int)
    last = np.floor(np.clip(high, -1.0, float(width)) - 0.5).astype(int)
    last[outside] = -1
    return np.maximum(first, 0), np.minimum(last, width - 1)


def _parts(counts: Array) -> list[slice]:
    """Return consecutive slices of the spans with a bounded number of pixels each."""
    total = np.cumsum(counts)
    marks = np.arange(_FRAGMENTS_AT_ONCE, int(total[-1]) if total.size else 0, _FRAGMENTS_AT_ONCE)
    cuts = np.unique([0, *np.searchsorted(total, marks), counts.size])
    return [slice(int(a), int(b)) for a, b in pairwise(cuts)]
