"""Completes and corrects a URDF's tree by what the robot's YAML says, before it is checked."""

from __future__ import annotations

import math
from collections.abc import Iterable
from fnmatch import fnmatchcase

import numpy as np
import pinocchio as pin

from equipoise.errors import NameNotFoundError, RobotFileError, quoted
from equipoise.robots.files.check_joint import LARGEST_ANGLE, MOVING
from equipoise.robots.files.description import Node
from equipoise.robots.files.extras_schema import CapsuleEntry, Extras, InertialEntry, ShapeEntry
from equipoise.robots.files.values import DECIMAL, LIMIT_SLACK, element

PATTERN = "*?["  # what makes a name of `locked` a pattern
Triple = tuple[float, float, float]

SHADES = {
    "light": (0.72, 0.74, 0.77, 1.0),
    "white": (0.92, 0.93, 0.94, 1.0),
    "dark": (0.22, 0.23, 0.26, 1.0),
}


def supplement(tree: Node, extras: Extras) -> Node:
    """Return the tree with frames, shapes, limits, inertias and locked joints of the extras.

    A palm with a skin gets a frame there, of the palm's name and `_skin`.

    Raises: NameNotFoundError, RobotFileError.
    """
    links = {node.get("name", ""): node for node in tree.findall("link")}
    joints = {node.get("name", ""): node for node in tree.findall("joint")}
    for name, limits in extras.limits.items():
        limit = _only(_named("joint", "limits", name, joints), "limit")
        limit.attrib.update(_numbers(limits.model_dump(exclude_none=True)))
    for name, inertial in extras.inertials.items():
        _correct_inertial(_named("link", "inertials", name, links), inertial)
    for name, value in extras.locked.items():
        if any(sign in name for sign in PATTERN):
            _lock_all(name, value, joints, extras)
        else:
            lock(_named("joint", "locked", name, joints), value)
    for frame in extras.frames:
        _named("link", f"frames, {frame.name}", frame.on, links)
        _add_frame(tree, frame.name, frame.on, frame.xyz, frame.rpy)
    known = set(links) | {frame.name for frame in extras.frames}
    for palm in extras.palms:
        if palm.skin > 0.0 and palm.frame in known:  # an unknown frame is refused later
            _add_frame(
                tree, f"{palm.name}_skin", palm.frame, (0.0, 0.0, palm.skin), (0.0, 0.0, 0.0)
            )
    if extras.shapes is not None:
        for name in extras.shapes:
            _named("link", "shapes", name, links)
        for name, link in links.items():
            _reshape(link, extras.shapes.get(name, ()))
    return tree


def _named(kind: str, key: str, name: str, known: dict[str, Node]) -> Node:
    if name not in known:
        raise NameNotFoundError(
            f"{kind} (named by the key {key!r} of the robot's YAML)", name, known
        )
    return known[name]


def _only(node: Node, tag: str) -> Node:
    child = node.find(tag)
    if child is None:
        child = element(tag)
        node.append(child)
    return child


def _numbers(values: dict[str, float]) -> dict[str, str]:
    return {key: repr(float(value)) for key, value in values.items()}


def _correct_inertial(link: Node, entry: InertialEntry) -> None:
    inertial = _only(link, "inertial")
    terms = entry.model_dump(exclude_none=True)
    mass = terms.pop("mass", None)
    if mass is not None:
        _only(inertial, "mass").set("value", repr(float(mass)))
    _only(inertial, "inertia").attrib.update(_numbers(terms))


def _lock_all(pattern: str, value: float, joints: dict[str, Node], extras: Extras) -> None:
    """Lock all joints that move and match, each at the nearest value that it can have."""
    matching = [name for name in joints if fnmatchcase(name, pattern)]
    if not matching:
        _named("joint", "locked", pattern, joints)
    for name in matching:
        if name not in extras.locked and joints[name].get("type") in MOVING:
            low, high = range_of(joints[name])
            lock(joints[name], min(max(value, low), high))


def lock(joint: Node, value: float) -> None:
    """Make a joint fixed where its coordinate is `value` [rad or m]."""
    name, kind = joint.get("name"), joint.get("type")
    if kind not in MOVING:
        raise RobotFileError(
            f"joint {name!r} cannot be locked: it is {kind}", remedy="Leave it out of 'locked'"
        )
    low, high = range_of(joint)
    if not low - LIMIT_SLACK <= value <= high + LIMIT_SLACK:
        raise RobotFileError(
            f"joint {quoted(name)} cannot be locked there: its range is {low:g} to {high:g} "
            f"{'m' if kind == 'prismatic' else 'rad'}",
            given=value,
            remedy="Lock it inside its range; angles are in rad, "
            f"{value:g} degrees are {math.radians(value):.4g} rad"
            if kind != "prismatic"
            else "Lock it inside its range [m]",
        )
    axis = _vector(joint.find("axis"), "xyz", (1.0, 0.0, 0.0))
    length = np.linalg.norm(axis)
    axis = axis / length if length > 0.0 else axis
    origin = _only(joint, "origin")
    T = pin.SE3(
        pin.rpy.rpyToMatrix(*_vector(origin, "rpy", (0.0, 0.0, 0.0))),
        _vector(origin, "xyz", (0.0, 0.0, 0.0)),
    )
    moved = pin.SE3.Identity()
    if kind == "prismatic":
        moved.translation = axis * value
    else:
        moved.rotation = pin.exp3(axis * value)
    T = T * moved
    origin.attrib.update(_placed(T))
    for tag in ("axis", "limit", "dynamics", "mimic", "safety_controller", "calibration"):
        for child in joint.findall(tag):
            joint.remove(child)
    joint.set("type", "fixed")


def range_of(joint: Node) -> tuple[float, float]:
    """Return the limits of a joint; two turns, or infinite, where it says none that is a number."""
    if joint.get("type") == "continuous":
        return -LARGEST_ANGLE, LARGEST_ANGLE
    limit, found = joint.find("limit"), []
    for key, without in (("lower", -math.inf), ("upper", math.inf)):
        text = None if limit is None else limit.get(key)
        found.append(
            float(text) if text is not None and DECIMAL.fullmatch(text.strip()) else without
        )
    return found[0], found[1]


def _vector(node: Node | None, key: str, default: Triple) -> np.ndarray:
    text = node.get(key) if node is not None else None
    if node is None or text is None:
        return np.array(default)
    try:
        values = np.array([float(x) for x in text.split()])
    except ValueError:
        values = np.full(3, np.nan)
    if values.shape != (3,) or not np.isfinite(values).all():
        raise RobotFileError(f"<{node.tag} {key}> of a locked joint: wanted 3 numbers", given=text)
    return values


def _placed(T: pin.SE3) -> dict[str, str]:
    rpy = pin.rpy.matrixToRpy(T.rotation)
    return {"xyz": _spaced(T.translation), "rpy": _spaced(rpy)}


def _spaced(values: Iterable[float]) -> str:
    return " ".join(repr(float(x)) for x in values)


def _add_frame(tree: Node, name: str, link: str, xyz: Triple, rpy: Triple) -> None:
    """Append a link without mass that is fixed to another."""
    tree.append(element("link", name=name))
    taken = {node.get("name") for node in tree.findall("joint")}
    own = f"{name}_fixed"
    while own in taken:
        own += "_"
    joint = element("joint", name=own, type="fixed")
    joint.append(element("parent", link=link))
    joint.append(element("child", link=name))
    joint.append(element("origin", xyz=xyz, rpy=rpy))
    tree.append(joint)


def _reshape(link: Node, entries: tuple[ShapeEntry, ...]) -> None:
    """Put our shapes in place of the URDF's, seen and felt."""
    for tag in ("collision", "visual"):
        for child in link.findall(tag):
            link.remove(child)
    for entry in entries:
        for tag in ("visual", "collision") if entry.collides else ("visual",):
            link.append(_shape(tag, entry, f"{link.get('name')} {entry.shade}"))


def _shape(tag: str, entry: ShapeEntry, material: str) -> Node:
    node, holder = element(tag), element("geometry")
    if entry.capsule is not None:
        T, length = _between(entry.capsule)
        holder.append(element("cylinder", radius=entry.capsule.radius, length=length))
        node.append(Node("origin", _placed(T)))
    else:
        node.append(element("origin", xyz=entry.xyz, rpy=entry.rpy))
        if entry.box is not None:
            holder.append(element("box", size=entry.box))
        else:
            holder.append(element("sphere", radius=entry.sphere))
    node.append(holder)
    if tag == "visual":
        colour = element("material", name=material)
        colour.append(element("color", rgba=SHADES[entry.shade]))
        node.append(colour)
    return node


def _between(capsule: CapsuleEntry) -> tuple[pin.SE3, float]:
    """Return where a cylinder lies whose z axis leads from start to end, and its length [m]."""
    start, end = np.array(capsule.start), np.array(capsule.end)
    length = float(np.linalg.norm(end - start))
    up = np.array([0.0, 0.0, 1.0])
    turn = pin.Quaternion.FromTwoVectors(up, (end - start) / length).toRotationMatrix()
    return pin.SE3(turn, (start + end) / 2.0), length
