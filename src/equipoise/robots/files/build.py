"""Turns a checked URDF tree into Pinocchio's model and geometry models."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import combinations
from pathlib import Path
from xml.etree import ElementTree

import coal
import pinocchio as pin

from equipoise.errors import RobotFileError, one_line
from equipoise.robots.base import FLOATING, Base
from equipoise.robots.files.finding import WARNING, Finding
from equipoise.robots.hulls import Hull, hull_of, is_mesh

ROOT_JOINT = "root_joint"
MUCH = 1.5  # times the volume of a mesh that its convex hull may have without a word


def build_model(tree: ElementTree.Element, base: Base = FLOATING) -> pin.Model:
    """Build the model with a base of the given kind.

    Raises: RobotFileError if Pinocchio refuses the tree.
    """
    text = ElementTree.tostring(tree, encoding="unicode")
    try:
        if base is FLOATING:
            return pin.buildModelFromXML(text, pin.JointModelFreeFlyer(), ROOT_JOINT)
        return pin.buildModelFromXML(text)
    except (RuntimeError, ValueError, ArithmeticError) as error:
        raise RobotFileError(f"Pinocchio cannot build the model: {one_line(error)}") from error


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
        raise RobotFileError(f"Pinocchio cannot build the shapes: {one_line(error)}") from error
    if as_capsules:
        for shape in geometry.geometryObjects:
            if isinstance(shape.geometry, coal.Cylinder):
                cylinder = shape.geometry
                shape.geometry = coal.Capsule(cylinder.radius, 2.0 * cylinder.halfLength)
    return geometry


def take_hulls(model: pin.Model, geometry: pin.GeometryModel) -> list[Finding]:
    """Put convex hulls in place of the meshes; warn where much of the free space is lost by that.

    Raises: RobotFileError for a mesh without corners, or not of finite numbers.
    """
    findings: list[Finding] = []
    hulls: dict[tuple[object, ...], Hull] = {}
    for shape in geometry.geometryObjects:
        if not is_mesh(shape.geometry):
            continue
        key = (shape.meshPath, tuple(shape.meshScale))
        hull = hulls.get(key)
        if hull is None:
            hull = hulls[key] = hull_of(shape)
        shape.geometry = hull.shape
        if hull.mesh_volume is not None and hull.volume > MUCH * hull.mesh_volume:
            times = hull.volume / max(hull.mesh_volume, 1e-12)
            findings.append(
                Finding(
                    WARNING,
                    f"link {link_of(model, shape)!r}, collision",
                    "the mesh is taken as its convex hull, which has "
                    f"{times:.3g} times its volume: the hollows count as solid",
                    remedy="Cut it into convex pieces if something is to reach into them",
                    given=Path(shape.meshPath).name,
                )
            )
    return findings


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
        if joint == 0:  # what is fixed to the world
            continue
        above = parents[joint]
        while above > 0 and above not in links_of:
            above = parents[above]
        pairs |= {(a, b) for a in links for b in links_of.get(above, ())}
    return pairs
