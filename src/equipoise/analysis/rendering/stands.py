"""Stands under what would hang in the air: seen, never touched."""

from __future__ import annotations

import coal
import numpy as np
import pinocchio as pin

from equipoise.analysis.rendering.part import Part
from equipoise.analysis.rendering.tessellation import tessellate
from equipoise.collision.scene import Scene
from equipoise.spatial import Array

RGB = np.array([0.42, 0.44, 0.47])
NEAR = 0.03  # [m] above something that a shape still stands on it
POST, PLATE, THICK = 0.022, 0.13, 0.016  # [m] radius of a post, of its plate, and its thickness
WIDE = 0.35  # [m] a shape that is wider stands on two posts
SUNK = 0.01  # [m] that a post goes into what it carries


def stands(scene: Scene, moving: frozenset[str] = frozenset()) -> list[Part]:
    """Return posts from the floor to each fixed shape that nothing is under.

    Bodies named in `moving` are pushed about and have none.
    """
    boxes = _boxes(scene, moving)
    parts = []
    for low, high in boxes:
        if low[2] > NEAR and not any(_carries(other, (low, high)) for other in boxes):
            parts += _under(low, high)
    return parts


def _boxes(scene: Scene, moving: frozenset[str]) -> list[tuple[Array, Array]]:
    """Return the corners of the box around each fixed shape, in the world."""
    found = []
    for body in scene.bodies:
        if body.frame is not None or body.name in moving:
            continue
        for index in scene.shapes_of(body.name):
            shape = scene.geometry.geometryObjects[index]
            mesh = tessellate(shape.geometry)
            if mesh is not None:
                places = mesh.moved(shape.placement).vertices
                found.append((places.min(axis=0), places.max(axis=0)))
    return found


def _carries(lower: tuple[Array, Array], upper: tuple[Array, Array]) -> bool:
    over = all(
        lower[0][i] <= upper[1][i] + NEAR and upper[0][i] <= lower[1][i] + NEAR for i in (0, 1)
    )
    return over and abs(lower[1][2] - upper[0][2]) < NEAR


def _under(low: Array, high: Array) -> list[Part]:
    middle, size = 0.5 * (low + high), high - low
    axis = int(size[1] > size[0])
    aside = np.zeros(3)
    aside[axis] = 0.5 * size[axis] - 0.1 if size[axis] > WIDE else 0.0
    places = [middle - aside, middle + aside] if aside.any() else [middle]
    height = low[2] + SUNK
    parts = []
    for x, y, _ in places:
        for shape, z in (
            (coal.Cylinder(POST, height), 0.5 * height),
            (coal.Cylinder(PLATE, THICK), 0.5 * THICK),
        ):
            mesh = tessellate(shape)
            if mesh is not None:
                T = pin.SE3(np.eye(3), np.array([x, y, z]))
                parts.append(Part(0, mesh.moved(T), RGB, shape, T))
    return parts
