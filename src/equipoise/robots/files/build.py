"""Turns a checked URDF tree into Pinocchio's model and geometry models."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import combinations
from xml.etree import ElementTree

import coal
import pinocchio as pin

from equipoise.errors import RobotFileError

ROOT_JOINT = "root_joint"


def build_model(tree: ElementTree.Element) -> pin.Model:
    """Build the model with a free base.

    Raises: RobotFileError if Pinocchio refuses the tree.
    """
    text = ElementTree.tostring(tree, encoding="unicode")
    try:
        return pin.buildModelFromXML(text, pin.JointModelFreeFlyer(), ROOT_JOINT)
    except (RuntimeError, ValueError, ArithmeticError) as error:
        raise RobotFileError(f"Pinocchio cannot build the model: {error}") from error


def build_geometry(
    tree: ElementTree.Element, model: pin.Model, kind: pin.GeometryType, *, as_capsules: bool
) -> pin.GeometryModel:
    """Build the collision or visual shapes; cylinders become capsules on request.

    Raises: RobotFileError if a shape or mesh cannot be read.
    """
    text = ElementTree.tostring(tree, encoding="unicode")
    try:
        geometry = pin.buildGeomFromUrdfString(model, text, kind)
    except (RuntimeError, ValueError, ArithmeticError) as error:
        raise RobotFileError(f"Pinocchio cannot build the shapes: {error}") from error
    if as_capsules:
        for shape in geometry.geometryObjects:
            if isinstance(shape.geometry, coal.Cylinder):
                cylinder = shape.geometry
                shape.geometry = coal.Capsule(cylinder.radius, 2.0 * cylinder.halfLength)
    return geometry


def link_of(model: pin.Model, shape: pin.GeometryObject) -> str:
    """Return the name of the link that carries a shape."""
    return model.frames[shape.parentFrame].name


def add_collision_pairs(
    model: pin.Model,
    geometry: pin.GeometryModel,
    disabled: Iterable[tuple[str, str]],
) -> None:
    """Watch every pair of shapes on different joints except the disabled pairs of links."""
    skipped = {frozenset(pair) for pair in disabled}
    shapes = list(geometry.geometryObjects)
    geometry.removeAllCollisionPairs()
    for (i, first), (j, second) in combinations(enumerate(shapes), 2):
        links = frozenset((link_of(model, first), link_of(model, second)))
        if first.parentJoint != second.parentJoint and links not in skipped:
            geometry.addCollisionPair(pin.CollisionPair(i, j))


def neighbouring_links(model: pin.Model, geometry: pin.GeometryModel) -> set[tuple[str, str]]:
    """Return the pairs of links with shapes that have no other such link between them."""
    links_of: dict[int, set[str]] = {}
    for shape in geometry.geometryObjects:
        links_of.setdefault(shape.parentJoint, set()).add(link_of(model, shape))
    parents, pairs = list(model.parents), set()
    for joint, links in links_of.items():
        above = parents[joint] if joint > 0 else 0
        while above > 0 and above not in links_of:
            above = parents[above]
        pairs |= {(a, b) for a in links for b in links_of.get(above, ()) if above > 0}
    return pairs
