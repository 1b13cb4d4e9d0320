"""The convex hull of points in space: by scipy where it is installed, by Coal where it is not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from equipoise.spatial.se3 import Array

THIN = 1e-8  # of the largest extent: flatter points are not given to Coal, which may end in them


@dataclass(frozen=True)
class SolidHull:
    """A hull: its `corners` (k,) and `triangles` (f, 3) by number, and its `volume` [m^3].

    Triangles run anticlockwise, seen from outside.
    """

    corners: Array
    triangles: Array
    volume: float


def solid_hull(points: Array, options: str | None = None) -> SolidHull | None:
    """Return the hull of points (n, 3) [m], None where they lie in a plane, or nearly.

    `options` are those of Qhull, which both do the work with; None: scipy's own.
    """
    try:
        from scipy.spatial import ConvexHull, QhullError
    except ModuleNotFoundError:
        return hull_by_coal(points)
    try:
        hull = ConvexHull(points, qhull_options=options)
    except QhullError:
        return None
    triangles = outward(points, hull.simplices.copy())
    return SolidHull(hull.vertices, triangles, float(hull.volume))


def hull_by_coal(points: Array) -> SolidHull | None:
    """Return the hull that Coal finds of points (n, 3) [m], None where they are nearly flat."""
    import coal

    middle = points.mean(axis=0)
    extents = np.linalg.svd(points - middle, compute_uv=False) if len(points) > 3 else np.zeros(3)
    if not extents[-1] > THIN * extents[0]:
        return None
    given = coal.StdVec_Vec3s()
    for point in points:
        given.append(point)
    hull = coal.Convex.convexHull(given, True, "Qt")
    there = np.array(hull.points())
    kept = np.array([_index(points, corner) for corner in there])
    faces = (hull.polygons(i) for i in range(hull.num_polygons))
    triangles = outward(points, kept[np.array([[f[0], f[1], f[2]] for f in faces])])
    return SolidHull(np.unique(triangles), triangles, float(hull.computeVolume()))


def outward(points: Array, triangles: Array) -> Array:
    """Return triangles (f, 3) of a hull, all turned so that their normals point outwards."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    inside = points[np.unique(triangles)].mean(axis=0)
    inwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), a - inside) < 0.0
    triangles[inwards] = triangles[inwards][:, [0, 2, 1]]
    return triangles


def _index(points: Array, corner: Array) -> int:
    return int(np.abs(points - corner).max(axis=1).argmin())
