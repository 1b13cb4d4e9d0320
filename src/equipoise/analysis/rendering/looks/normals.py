"""Normals of triangles: smooth where the surface is, sharp at its edges."""

from __future__ import annotations

import numpy as np

from equipoise.analysis.rendering.tessellation import Mesh
from equipoise.spatial import Array, Indices

CREASE = np.cos(np.radians(38.0))  # faces that differ by more meet in an edge


def with_normals(vertices: Array, triangles: Indices, crease: float = CREASE) -> Mesh:
    """Return a mesh whose corners have the mean normal of the faces around that lie alike.

    `vertices` (n, 3), `triangles` (m, 3). Faces without an area are left out; corners that have
    the same normal are one corner.
    """
    corners = vertices[triangles]
    face = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(face, axis=1)
    kept = area > 1e-12
    triangles, face, area = triangles[kept], face[kept], area[kept]
    unit = face / area[:, None]
    normals = _averaged(triangles, face, unit, len(vertices), crease)
    place = triangles.reshape(-1)
    key = np.column_stack([place, np.round(100.0 * normals).astype(int)])
    _, first, index = np.unique(key, axis=0, return_index=True, return_inverse=True)
    return Mesh(vertices[place[first]], normals[first], index.reshape(-1, 3))


def _averaged(triangles: Indices, face: Array, unit: Array, count: int, crease: float) -> Array:
    """Return the normal (3 m, 3) of each corner: the mean of `face` (m, 3) around it."""
    place = triangles.reshape(-1)
    owner = np.repeat(np.arange(len(triangles)), 3)
    order = np.argsort(place, kind="stable")
    starts = np.searchsorted(place[order], np.arange(count + 1))
    total = np.zeros((len(place), 3))
    around = np.diff(starts)[place]
    # corner by corner of each vertex's ring: the k-th face around every vertex at once
    for k in range(int(around.max(initial=0))):
        has = around > k
        other = owner[order[starts[place[has]] + k]]
        alike = np.einsum("ij,ij->i", unit[owner[has]], unit[other]) > crease
        total[np.flatnonzero(has)[alike]] += face[other[alike]]
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return np.where(length > 0.0, total / np.maximum(length, 1e-300), unit[owner])
