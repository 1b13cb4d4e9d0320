"""The support polygon: the convex hull of the soles on the floor, as half-planes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from scipy.spatial import ConvexHull

from equipoise.compiled.compilation import entrance
from equipoise.robots import Sole
from equipoise.spatial import Array


def sole_corners(sole: Sole, T_world_sole: pin.SE3) -> Array:
    """Return the four corners (4, 3) [m] of a sole's rectangle in world coordinates."""
    return sole.corners @ T_world_sole.rotation.T + T_world_sole.translation


@dataclass(frozen=True)
class SupportPolygon:
    """Half-planes `normals @ p_xy <= offsets`, unit outward normals, and the corners in order."""

    normals: Array
    offsets: Array
    vertices: Array

    @classmethod
    def of_points(cls, points: Array) -> SupportPolygon:
        """Return the hull of points (k, 2) or (k, 3) [m]; only x and y count."""
        hull = ConvexHull(np.asarray(points)[:, :2])
        equations = _without_duplicates(hull.equations)
        normals = np.ascontiguousarray(equations[:, :2])
        return cls(normals, -equations[:, 2], np.asarray(points)[hull.vertices, :2])

    def margin(self, p: Array) -> float:
        """Return the distance [m] of `p` to the nearest edge; negative outside."""
        return least_room(self.normals, self.offsets, float(p[0]), float(p[1]))


@entrance
def least_room(normals: np.ndarray, offsets: np.ndarray, x: float, y: float) -> float:
    """Return the least `offset - normal . (x, y)`."""
    room = np.inf
    for i in range(offsets.shape[0]):
        room = min(room, offsets[i] - normals[i, 0] * x - normals[i, 1] * y)
    return room


def _without_duplicates(equations: Array) -> Array:
    kept: list[Array] = []
    for row in equations:
        if not any(np.allclose(row, other, atol=1e-9) for other in kept):
            kept.append(row)
    return np.array(kept)
