"""Checks one <link>: mass, inertia, shapes; returns a clean copy for Pinocchio."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from equipoise.robots.files.description import Node
from equipoise.robots.files.meshes import MeshFolders
from equipoise.robots.files.values import (
    Report,
    element,
    only_child,
    read_number,
    read_numbers,
    read_origin,
    read_positive,
    warn_unknown,
)

Colours = Mapping[str, tuple[float, ...]]  # material -> red, green, blue, opacity

INERTIA_KEYS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
SHAPES = ("box", "cylinder", "sphere", "mesh")
NEGLIGIBLE, LIGHT = 1e-5, 0.5  # [kg m^2], [kg] up to which a wrong inertia is mended, and told
BALL = 0.4e-4  # [m^2] two fifths of the square of 1 cm
INERTIA_TOLERANCE = 1e-6  # relative; covers the rounding of printed numbers


@dataclass(frozen=True)
class CheckedLink:
    """A clean link, its mass [kg] (0 where none is given), and whether it could move by itself."""

    clean: Node
    mass: float = 0.0
    has_full_inertia: bool = False


def check_link(
    report: Report, node: Node, name: str, *, meshes: MeshFolders, colours: Colours
) -> CheckedLink:
    """Check a link and return a clean copy."""
    place = f"link {name!r}"
    clean = element("link", name=name)
    warn_unknown(report, node, place, ("name",), ("inertial", "visual", "collision"))
    inertial = only_child(report, node, place, "inertial")
    checked = CheckedLink(clean)
    if inertial is not None:
        checked = _check_inertial(report, inertial, place, clean)
    for tag in ("visual", "collision"):
        for index, shape in enumerate(node.findall(tag)):
            _check_shape(report, shape, f"{place}, {tag} {index}", clean, meshes, colours)
    return checked


def _check_inertial(report: Report, node: Node, place: str, clean: Node) -> CheckedLink:
    """Check mass and inertia and append a clean <inertial>."""
    warn_unknown(report, node, place, (), ("origin", "mass", "inertia"))
    mass_node = only_child(report, node, place, "mass", needed=True)
    inertia_node = only_child(report, node, place, "inertia", needed=True)
    origin = read_origin(report, node, place)
    if mass_node is None or inertia_node is None:
        return CheckedLink(clean)
    mass = read_number(report, mass_node, place, "value")
    read = [read_number(report, inertia_node, place, key) for key in INERTIA_KEYS]
    terms = [term for term in read if term is not None]
    if mass is None or len(terms) < len(read):
        return CheckedLink(clean)
    if mass == 0.0 and not any(terms):
        return CheckedLink(clean)
    if mass == 0.0 and np.abs(terms).max() <= NEGLIGIBLE:
        problem = "an inertia without a mass, too small to count, is left out"
        report.warning(inertia_node, place, problem)
        return CheckedLink(clean)
    if mass <= 0.0:
        report.error(
            mass_node,
            place,
            "the mass must be positive",
            given=mass_node.get("value"),
            remedy="Give the true mass [kg], or leave <inertial> out of a fixed massless frame",
        )
        return CheckedLink(clean)
    terms, smallest = _checked_inertia(report, inertia_node, place, terms, mass)
    part = element("inertial")
    part.extend([] if origin is None else [origin])
    part.append(element("mass", value=mass))
    part.append(element("inertia", **dict(zip(INERTIA_KEYS, terms, strict=True))))
    clean.append(part)
    return CheckedLink(clean, mass, smallest > 0.0)


def _checked_inertia(
    report: Report, node: Node, place: str, terms: list[float], mass: float
) -> tuple[list[float], float]:
    """Check that some body has this inertia; return it and its least moment.

    A least moment of zero belongs to a thin rod or a point: a link may have it only beside other
    masses that are fixed to it (see `check_tree`). What no body has, but is too small to count, is
    replaced by the inertia of a small ball of this mass.
    """
    ixx, ixy, ixz, iyy, iyz, izz = terms
    principal = np.linalg.eigvalsh([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
    tolerance = INERTIA_TOLERANCE * abs(principal).max()
    problem = ""
    if principal[0] < -tolerance:
        problem = "the inertia is not positive definite"
    elif principal[2] > principal[0] + principal[1] + tolerance:
        problem = (
            "no body has this inertia: the largest principal moment exceeds the sum of the others"
        )
    negligible = abs(principal).max() <= NEGLIGIBLE and mass <= LIGHT
    given = ", ".join(f"{moment:.6g}" for moment in principal) + " kg m^2 (principal moments)"
    if problem and negligible:
        ball = max(BALL * mass, float(abs(principal).max()))
        report.warning(
            node,
            place,
            f"{problem}; it is too small to count: that of a ball, {ball:.2g} kg m^2, is taken",
            given=given,
            remedy="Leave <inertial> out of a link that is only a frame",
        )
        return [ball, 0.0, 0.0, ball, 0.0, ball], ball
    if problem:
        report.error(
            node,
            place,
            problem,
            given=given,
            remedy="Check the units (kg m^2) and the signs of the products of inertia",
        )
    return terms, float(principal[0])


def _check_shape(
    report: Report, node: Node, place: str, clean: Node, meshes: MeshFolders, colours: Colours
) -> None:
    """Check a <visual> or <collision> and append a clean copy."""
    known = ("origin", "geometry", *(("material",) if node.tag == "visual" else ()))
    warn_unknown(report, node, place, ("name",), known)
    geometry = only_child(report, node, place, "geometry", needed=True)
    origin = read_origin(report, node, place)
    if geometry is None:
        return
    kinds = list(geometry)
    if len(kinds) != 1 or kinds[0].tag not in SHAPES:
        report.error(
            geometry,
            place,
            "<geometry> needs exactly one known shape",
            given=", ".join(str(kind.tag) for kind in kinds) or "nothing",
            remedy=f"Use one of {', '.join(SHAPES)}",
        )
        return
    shape = _checked_primitive(report, kinds[0], place, meshes)
    if shape is None:
        return
    part, holder = element(node.tag), element("geometry")
    holder.append(shape)
    part.extend([holder] if origin is None else [origin, holder])
    colour = _colour(report, node, place, colours) if node.tag == "visual" else None
    if colour is not None:
        # A name of its own each: URDF parsers disagree about materials of the same name.
        material = element("material", name=f"{place}, line {node.line}")
        material.append(element("color", rgba=colour))
        part.append(material)
    clean.append(part)


def _checked_primitive(report: Report, node: Node, place: str, meshes: MeshFolders) -> Node | None:
    if node.tag == "mesh":
        return meshes.checked(report, node, place)
    if node.tag == "box":
        size = read_numbers(report, node, place, "size", 3)
        if size is not None and min(size) <= 0.0:
            report.error(node, place, "a box needs three positive sizes", given=node.get("size"))
            return None
        return None if size is None else element("box", size=size)
    keys = ("radius", "length") if node.tag == "cylinder" else ("radius",)
    values = {key: read_positive(report, node, place, key, "m") for key in keys}
    return None if None in values.values() else element(node.tag, **values)


def _colour(report: Report, node: Node, place: str, colours: Colours) -> tuple[float, ...] | None:
    material = only_child(report, node, place, "material")
    if material is None:
        return None
    return read_colour(report, material, place) or colours.get(material.get("name", ""))


def read_colour(report: Report, material: Node, place: str) -> tuple[float, ...] | None:
    """Return a material's red, green, blue and opacity in 0..1, or None if it has no colour."""
    node = material.find("color")
    if node is None:
        return None
    rgba = read_numbers(report, node, place, "rgba", 4)
    if rgba is not None and not (min(rgba) >= 0.0 and max(rgba) <= 1.0):
        report.error(node, place, "a colour needs four numbers in 0..1", given=node.get("rgba"))
        return None
    return rgba
