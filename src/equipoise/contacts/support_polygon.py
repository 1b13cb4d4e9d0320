"""The support polygon: the convex hull of the soles on the floor, as half-planes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from equipoise.compiled import entrance
from equipoise.errors import InputError, ShapeError
from equipoise.robots import Sole
from equipoise.spatial import Array, convex_hull
from equipoise.spatial.numbers import real_array

LEAST_EXTENT = 1e-6  # [m] across its narrowest direction, below which a polygon is a line


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
        """Return the hull of points (k, 2) or (k, 3) [m]; only x and y count.

        Raises: `InputError` for points that are not finite or lie on a line.
        """
        given = real_array("the points of a support polygon", points, None, finite=False)
        if given.ndim != 2 or given.shape[1] not in (2, 3):
            raise ShapeError("the points of a support polygon", given.shape, ("k", "2 or 3"))
        seen = given[:, :2]
        corners = seen[convex_hull(seen)] if np.isfinite(seen).all() else seen[:0]
        if len(corners) < 3 or not _extent(corners) > LEAST_EXTENT:
            raise InputError(
                "a support polygon needs points around an area; these lie on a line or in a point, "
                "or are not finite",
                given=seen.tolist(),
                remedy="Give corners of soles, or at least three feet that are not in a line; on "
                "a line no polygon holds the centre of mass",
            )
        edges = np.roll(corners, -1, axis=0) - corners
        normals = np.column_stack((edges[:, 1], -edges[:, 0]))
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        return cls(normals, np.einsum("ij,ij->i", normals, corners), corners)

    def holds_margin(self, margin: float) -> bool:
        """Return whether any point is `margin` [m] inside every edge."""
        left = self.vertices
        for normal, offset in zip(self.normals, self.offsets - margin, strict=True):
            left = _cut(left, normal, offset)
        return len(left) > 0

    def margin(self, p: Array) -> float:
        """Return the distance [m] of `p` to the nearest edge; negative outside."""
        return least_room(self.normals, self.offsets, float(p[0]), float(p[1]))


def _cut(corners: Array, normal: Array, offset: float) -> Array:
    """Return the corners of what is left of a convex polygon (k, 2) where `normal . p <= offset`.

    Source: Sutherland and Hodgman 1974, one edge.
    """
    beyond = corners @ normal - offset
    kept: list[Array] = []
    for k, here in enumerate(beyond):
        before = beyond[k - 1]
        if (here > 0.0) != (before > 0.0):
            share = before / (before - here)
            kept.append(corners[k - 1] + share * (corners[k] - corners[k - 1]))
        if here <= 0.0:
            kept.append(corners[k])
    return np.array(kept).reshape(-1, 2)


def _extent(corners: Array) -> float:
    """Return the width [m] of a convex polygon (k, 2) across its longest diagonal."""
    apart = corners[:, None] - corners[None]
    lengths = np.linalg.norm(apart, axis=2)
    i, j = np.unravel_index(np.argmax(lengths), lengths.shape)
    along = apart[i, j] / max(lengths[i, j], np.finfo(float).tiny)
    return float(np.ptp(corners @ np.array([-along[1], along[0]])))


@entrance
def least_room(normals: np.ndarray, offsets: np.ndarray, x: float, y: float) -> float:
    """Return the least `offset - normal . (x, y)`."""
    room = np.inf
    for i in range(offsets.shape[0]):
        room = min(room, offsets[i] - normals[i, 0] * x - normals[i, 1] * y)
    return room
