"""Collision and visual shapes as triangles with outward normals, for drawing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import coal
import numpy as np
import pinocchio as pin

from equipoise.spatial import Array, Indices
from equipoise.spatial.solid_hull import solid_hull

SEGMENTS = 24


@dataclass(frozen=True)
class Mesh:
    """Triangles (m, 3) of indices into `vertices` (n, 3) [m] with unit `normals` (n, 3).

    The corners of a triangle run anticlockwise seen from outside.
    """

    vertices: Array
    normals: Array
    triangles: Indices

    def moved(self, T: pin.SE3) -> Mesh:
        """Return the mesh in the axes that `T` maps to."""
        R = T.rotation
        return Mesh(self.vertices @ R.T + T.translation, self.normals @ R.T, self.triangles)


def tessellate(geometry: coal.CollisionGeometry, segments: int = SEGMENTS) -> Mesh | None:
    """Return a Coal shape as triangles, round ones with `segments` around; None for planes.

    Corners of round shapes lie on the true surface, so the mesh lies inside it.
    """
    for kind, triangles_of in SHAPES.items():
        if isinstance(geometry, kind):
            return triangles_of(geometry, segments)
    return None


def _box(shape: coal.Box, segments: int) -> Mesh:
    half = np.asarray(shape.halfSide, dtype=float)
    corners: list[Array] = []
    normals: list[Array] = []
    triangles: list[tuple[int, int, int]] = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for side in (-1.0, 1.0):
            start = len(corners)
            for a, b in ((-1.0, -1.0), (side, -side), (1.0, 1.0), (-side, side)):
                corner = np.zeros(3)
                corner[[axis, u, v]] = side, a, b
                corners.append(corner * half)
                normals.append(side * np.eye(3)[axis])
            triangles += [(start, start + 1, start + 2), (start, start + 2, start + 3)]
    return Mesh(np.array(corners), np.array(normals), np.array(triangles))


def _arc(radius: float, z: float, start: float, stop: float, segments: int) -> Array:
    """Return a profile (k, 4) of radius, height and their normal; 1 stands for a quarter turn."""
    count = max(2, round(segments / 4 * (stop - start))) + 1
    angle = np.linspace(start, stop, count) * np.pi / 2.0
    cosine, sine = np.cos(angle), np.sin(angle)
    cosine[np.abs(np.linspace(start, stop, count)) == 1.0] = 0.0
    return np.column_stack([radius * cosine, z + radius * sine, cosine, sine])


def _sphere(shape: coal.Sphere, segments: int) -> Mesh:
    return _revolved([_arc(shape.radius, 0.0, -1.0, 1.0, segments)], segments)


def _capsule(shape: coal.Capsule, segments: int) -> Mesh:
    bottom = _arc(shape.radius, -shape.halfLength, -1.0, 0.0, segments)
    top = _arc(shape.radius, shape.halfLength, 0.0, 1.0, segments)
    return _revolved([np.vstack([bottom, top])], segments)


def _cylinder(shape: coal.Cylinder, segments: int) -> Mesh:
    return _frustum(shape.radius, shape.radius, shape.halfLength, segments)


def _cone(shape: coal.Cone, segments: int) -> Mesh:
    return _frustum(shape.radius, 0.0, shape.halfLength, segments)


def _frustum(bottom: float, top: float, half: float, segments: int) -> Mesh:
    slope = np.array([2.0 * half, bottom - top])
    slope /= np.linalg.norm(slope)
    side = np.array([[bottom, -half, *slope], [top, half, *slope]])
    floor = np.array([[0.0, -half, 0.0, -1.0], [bottom, -half, 0.0, -1.0]])
    lid = np.array([[top, half, 0.0, 1.0], [0.0, half, 0.0, 1.0]])
    return _revolved([floor, side, lid], segments)


def _ellipsoid(shape: coal.Ellipsoid, segments: int) -> Mesh:
    radii = np.asarray(shape.radii, dtype=float)
    unit = _revolved([_arc(1.0, 0.0, -1.0, 1.0, segments)], segments)
    normals = unit.vertices / radii
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Mesh(unit.vertices * radii, normals, unit.triangles)


def _revolved(profiles: Sequence[Array], segments: int) -> Mesh:
    """Turn profiles about z; each runs upwards on the outside, from the lower pole to the upper."""
    angle = np.arange(segments) * 2.0 * np.pi / segments
    direction = np.column_stack([np.cos(angle), np.sin(angle)])
    vertices, normals, triangles = [], [], []
    start = 0
    for profile in profiles:
        for radius, z, normal_r, normal_z in profile:
            vertices.append(np.column_stack([radius * direction, np.full(segments, z)]))
            normals.append(np.column_stack([normal_r * direction, np.full(segments, normal_z)]))
        for ring in range(len(profile) - 1):
            a = start + ring * segments + np.arange(segments)
            b = start + ring * segments + np.roll(np.arange(segments), -1)
            if profile[ring, 0] > 0.0:
                triangles.append(np.column_stack([a, b, b + segments]))
            if profile[ring + 1, 0] > 0.0:
                triangles.append(np.column_stack([a, b + segments, a + segments]))
        start += len(profile) * segments
    return Mesh(np.vstack(vertices), np.vstack(normals), np.vstack(triangles))


def _hull(shape: coal.ConvexBase, segments: int) -> Mesh | None:
    if not hasattr(shape, "points"):
        return None
    points = np.array(shape.points())
    hull = solid_hull(points)
    return None if hull is None else _flat(points[hull.triangles])


def _triangle_mesh(model: coal.BVHModelBase, segments: int) -> Mesh:
    vertices = np.array(model.vertices())
    indices = (model.tri_indices(i) for i in range(model.num_tris))
    return _flat(vertices[np.array([[t[0], t[1], t[2]] for t in indices]).reshape(-1, 3)])


def _flat(corners: Array) -> Mesh:
    """Return the mesh of triangles (m, 3, 3), each with its own corners and one normal."""
    face = _face_vectors(corners)
    length = np.linalg.norm(face, axis=1)
    corners, face = corners[length > 0.0], face[length > 0.0] / length[length > 0.0, None]
    indices = np.arange(3 * len(corners)).reshape(-1, 3)
    return Mesh(corners.reshape(-1, 3), np.repeat(face, 3, axis=0), indices)


def _face_vectors(corners: Array) -> Array:
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


# Coal's kinds of shapes, those of `segments` around among them; its planes have no triangles
SHAPES: dict[type, Callable[[Any, int], Mesh | None]] = {
    coal.Box: _box,
    coal.Sphere: _sphere,
    coal.Ellipsoid: _ellipsoid,
    coal.Capsule: _capsule,
    coal.Cylinder: _cylinder,
    coal.Cone: _cone,
    coal.ConvexBase: _hull,
    coal.BVHModelBase: _triangle_mesh,
}
