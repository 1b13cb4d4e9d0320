"""The convex hull of points in a plane."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from equipoise.spatial.se3 import Array

STRAIGHT = 1e-12  # of the squared size: the area below which three points are on a line


def convex_hull(points: Array) -> Array:
    """Return the indices (m,) of the corners of points (k, 2), anticlockwise.

    Points on an edge are no corners; fewer than three corners are left of points on a line.
    """
    points = np.asarray(points, dtype=float)
    order = np.lexsort((points[:, 1], points[:, 0]))
    size = np.ptp(points, axis=0).max() if len(points) else 0.0
    least = STRAIGHT * float(size) ** 2
    lower, upper = (_chain(points, one_way, least) for one_way in (order, order[::-1]))
    return np.array([*lower[:-1], *upper[:-1]], dtype=int)


def _chain(points: Array, order: NDArray[np.intp], least: float) -> list[int]:
    """Return those of the points, in their order, at which a path to the last turns left."""
    kept: list[int] = []
    for k in order:
        while len(kept) > 1:
            u, v = points[kept[-1]] - points[kept[-2]], points[k] - points[kept[-1]]
            if u[0] * v[1] - u[1] * v[0] > least:
                break
            kept.pop()
        kept.append(int(k))
    return kept
