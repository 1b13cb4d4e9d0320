"""Convex shapes as kernels know them: a core (point, segment, box, cylinder, hull) and a radius."""

from __future__ import annotations

from typing import NamedTuple

import coal
import numpy as np
import pinocchio as pin

from equipoise.errors import InputError
from equipoise.spatial import Array
from equipoise.spatial.solid_hull import solid_hull

# kinds of cores; a sphere is a segment without length
SEGMENT, BOX, CYLINDER, HULL = range(4)


class Core(NamedTuple):
    """What a shape looks like without its radius.

    `size` (3,): half length along z for a segment; half sides for a box; radius, half length for a
    cylinder. `points` (k, 3) are the corners of a hull. `centre` (3,) and `reach` are of a ball
    around the whole shape.
    """

    kind: int
    size: Array
    radius: float
    points: Array
    centre: Array
    reach: float


def core_of(shape: pin.GeometryObject) -> Core:
    """Return the core of a shape. A mesh is taken as its convex hull.

    Raises: `InputError` for a kind of shape that is not known.
    """
    geometry, none, origin = shape.geometry, np.zeros((0, 3)), np.zeros(3)
    if isinstance(geometry, coal.Sphere):
        size = np.zeros(3)
        return Core(SEGMENT, size, geometry.radius, none, origin, geometry.radius)
    if isinstance(geometry, coal.Capsule):
        size = np.array([geometry.halfLength, 0.0, 0.0])
        reach = geometry.halfLength + geometry.radius
        return Core(SEGMENT, size, geometry.radius, none, origin, reach)
    if isinstance(geometry, coal.Box):
        size = np.array(geometry.halfSide)
        return Core(BOX, size, 0.0, none, origin, float(np.linalg.norm(size)))
    if isinstance(geometry, coal.Cylinder):
        size = np.array([geometry.radius, geometry.halfLength, 0.0])
        return Core(CYLINDER, size, 0.0, none, origin, float(np.hypot(size[0], size[1])))
    points = corners_of(geometry)
    if points is None or not len(points):
        raise InputError(
            f"collision shape {shape.name!r} is of a kind that distances are not known for",
            given=type(geometry).__name__,
            known=("box", "sphere", "cylinder", "capsule", "mesh (taken as its convex hull)"),
        )
    centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
    reach = float(np.linalg.norm(points - centre, axis=1).max())
    return Core(HULL, np.zeros(3), 0.0, points, centre, reach)


def corners_of(geometry: coal.CollisionGeometry) -> Array | None:
    """Return the corners (k, 3) of the convex hull of a mesh or hull, None for other shapes."""
    if isinstance(geometry, coal.BVHModelBase):
        points = np.array(geometry.vertices())
    elif isinstance(geometry, coal.ConvexBase):
        points = np.array(geometry.points())
    else:
        return None
    if len(points) < 5:
        return points
    hull = solid_hull(points)
    return points if hull is None else points[hull.corners]  # flat: every point may be a corner
