"""Meshes as convex hulls: what collisions are looked at with, and how much of a mesh that loses."""

from __future__ import annotations

from dataclasses import dataclass

import coal
import numpy as np
import pinocchio as pin

from equipoise.errors import RobotFileError
from equipoise.spatial import Array
from equipoise.spatial.solid_hull import solid_hull

THINNEST = 1e-4  # [m] a hull is made this thick where its mesh has no extent
LARGEST_COORDINATE = 1e6  # [m]
OPTIONS = (
    "Qt"  # of qhull, in scipy first if it is there: where it gives up inside Coal, the process ends
)


@dataclass(frozen=True)
class Hull:
    """The convex hull of a mesh, the volume [m^3] of both; that of a mesh with holes is None."""

    shape: coal.Convex
    volume: float
    mesh_volume: float | None


def is_mesh(geometry: coal.CollisionGeometry) -> bool:
    """Say whether a shape is a mesh, which Coal takes as hollow."""
    return isinstance(geometry, coal.BVHModelBase)


def hull_of(shape: pin.GeometryObject) -> Hull:
    """Return the convex hull of a mesh.

    A flat one is given a thickness of `THINNEST` [m].
    Raises: `RobotFileError` for a mesh that has no corners, or not of finite numbers.
    """
    mesh = shape.geometry
    points = np.array(mesh.vertices(), dtype=float).reshape(-1, 3)
    if not len(points):
        raise RobotFileError(f"The mesh of {shape.name!r} has no corners", given=shape.meshPath)
    if not (np.abs(points) <= LARGEST_COORDINATE).all():
        raise RobotFileError(
            f"The mesh of {shape.name!r} has corners that are not finite, or absurdly far away",
            given=shape.meshPath,
            remedy="Write it anew, in metres",
        )
    corners, volume = _hull(_with_extent(points))
    given = coal.StdVec_Vec3s()
    for corner in corners:
        given.append(corner)
    convex = coal.Convex.convexHull(given, True, OPTIONS)
    return Hull(convex, volume, _volume_of(mesh, points))


def _with_extent(points: Array) -> Array:
    """Return the points, doubled a little apart along directions in which they lie in a plane."""
    middle = points.mean(axis=0)
    distinct = np.unique(points - middle, axis=0)
    # three axes also of one or two points; of many the other side would be a matrix of thousands
    _, _, axes = np.linalg.svd(distinct, full_matrices=len(distinct) < 3)
    for axis in axes:
        if np.ptp((points - middle) @ axis) < THINNEST:
            points = np.concatenate(
                (points + 0.5 * THINNEST * axis, points - 0.5 * THINNEST * axis)
            )
    return points


def _hull(points: Array) -> tuple[Array, float]:
    """Return the corners (k, 3) of the convex hull and its volume."""
    hull = solid_hull(points, OPTIONS)
    if hull is None:  # too thin for exact work, though with an extent: the box around it
        points = _box_around(points)
        hull = solid_hull(points, OPTIONS)
    if hull is None:
        raise RobotFileError("A mesh is too thin for a hull", given=np.ptp(points, axis=0))
    return points[hull.corners], hull.volume


def _box_around(points: Array) -> Array:
    """Return the corners (8, 3) of a box around the points, along their principal directions."""
    middle = points.mean(axis=0)
    _, _, axes = np.linalg.svd(points - middle, full_matrices=False)
    along = (points - middle) @ axes.T
    low, high = along.min(axis=0), along.max(axis=0)
    wider = 0.5 * np.maximum(THINNEST - (high - low), 0.0)
    ends = np.stack((low - wider, high + wider))
    corners = [[ends[i, 0], ends[j, 1], ends[k, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    return middle + np.array(corners) @ axes


def _volume_of(mesh: coal.BVHModelBase, points: Array) -> float | None:
    """Return the volume [m^3] of a mesh whose every edge has two triangles, None for others."""
    triangles = np.array(
        [[t[0], t[1], t[2]] for t in (mesh.tri_indices(i) for i in range(mesh.num_tris))]
    ).reshape(-1, 3)
    size = float(np.ptp(points, axis=0).max())
    _, same = np.unique(np.round(points / max(size, THINNEST), 9), axis=0, return_inverse=True)
    joined = same.reshape(-1)[triangles]
    joined = joined[(joined != np.roll(joined, 1, axis=1)).all(axis=1)]
    edges = np.concatenate([joined[:, pair] for pair in ([0, 1], [1, 2], [2, 0])])
    edges = np.sort(edges, axis=1)
    if not len(edges) or (np.unique(edges, axis=0, return_counts=True)[1] % 2).any():
        return None
    a, b, c = (points[triangles[:, k]] - points.mean(axis=0) for k in range(3))
    return abs(float(np.einsum("ij,ij->", a, np.cross(b, c)))) / 6.0
