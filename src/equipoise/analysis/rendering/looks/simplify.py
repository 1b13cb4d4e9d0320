"""Fewer triangles, chosen so that the surface changes least."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from equipoise.analysis.rendering.looks.normals import with_normals
from equipoise.analysis.rendering.tessellation import Mesh
from equipoise.spatial import Array, Indices

FINEST = 5e-4  # [m] corners that are nearer are one, whatever is asked for
COARSER = 1.25  # how much wider cells become from one try to the next
DETAIL = 4  # times the wanted triangles that are left for edges to collapse
CAREFUL = 3.0  # how fast the tolerance of fast-simplification grows; its default tears thin parts
FEWEST = 150  # triangles that every mesh may have

Triangles = tuple[Array, Indices]  # corners (n, 3) [m] and their indices (m, 3)


def simplified(meshes: Sequence[Triangles], most: int) -> list[Mesh]:
    """Return the meshes with about `most` triangles together, with normals; small ones keep theirs.

    Edges are collapsed by their quadric errors where the package fast-simplification is installed;
    else corners in one cell of a grid become one.
    Source: Garland and Heckbert, Surface simplification using quadric error metrics (1997);
    Rossignac and Borrel, Multi-resolution 3D approximations for rendering complex scenes (1993).
    """
    welded = [_clustered(*mesh, FINEST) for mesh in meshes]
    shares = _shares(welded, most)
    return [with_normals(*_reduced(*mesh, n)) for mesh, n in zip(welded, shares, strict=True)]


def _shares(meshes: Sequence[Triangles], most: int) -> list[int]:
    """Return how many triangles each mesh may have: as its extent, not as its detail."""
    extents = np.array([float(np.ptp(places, axis=0).max(initial=0.0)) for places, _ in meshes])
    total = float(extents.sum()) or 1.0
    return [max(FEWEST, int(most * extent / total)) for extent in extents]


def _reduced(vertices: Array, triangles: Indices, most: int) -> Triangles:
    if len(triangles) <= most:
        return vertices, triangles
    try:
        from fast_simplification import simplify
    except ImportError:
        return _coarser(vertices, triangles, most)
    # screws and writing go with the cells, so that what is left is not spent on them
    places, faces = _coarser(vertices, triangles, DETAIL * most)
    if len(faces) <= most:
        return places, faces
    places, faces = simplify(
        np.ascontiguousarray(places, dtype=np.float32),
        np.ascontiguousarray(faces, dtype=np.int32),
        target_count=most,
        agg=CAREFUL,
    )
    return np.asarray(places, dtype=float), np.asarray(faces, dtype=int)


def _coarser(vertices: Array, triangles: Indices, most: int) -> Triangles:
    if len(triangles) <= most:
        return vertices, triangles
    cell = 2.0 * FINEST
    while True:
        places, faces = _clustered(vertices, triangles, cell)
        if len(faces) <= most:
            return places, faces
        cell *= COARSER


def _clustered(vertices: Array, triangles: Indices, cell: float) -> Triangles:
    """Return mean corners (k, 3) of the cells and the triangles that still have three of them."""
    _, index = np.unique(np.floor(vertices / cell).astype(int), axis=0, return_inverse=True)
    index = index.reshape(-1)
    count = np.bincount(index)
    places = np.column_stack([np.bincount(index, vertices[:, k]) / count for k in range(3)])
    faces = index[triangles]
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (a != c)]
    _, first = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    return places, faces[np.sort(first)]
