"""Reads which joints of a URDF follow another by <mimic>; locks those whose leader is fixed."""

from __future__ import annotations

import math
from fnmatch import fnmatchcase

from equipoise.robots.files.check_joint import MOVING
from equipoise.robots.files.description import Node
from equipoise.robots.files.extras_schema import Extras
from equipoise.robots.files.laws import Law, resolved
from equipoise.robots.files.supplement import lock, range_of
from equipoise.robots.files.values import DECIMAL


def take_laws(tree: Node, extras: Extras) -> tuple[list[Law], set[str]]:
    """Take the <mimic> out of every joint that can follow; return the laws, and who was locked.

    A follower that the YAML locks follows nothing, and its leader moves without it. One whose
    leader is fixed, or locked there, is locked where that puts it. One whose leader does not exist
    is locked at zero, and keeps its <mimic>, which the check tells of.
    Raises: RobotFileError.
    """
    joints = {node.get("name", ""): node for node in tree.findall("joint")}
    laws, mimics = [], {}
    for name, node in joints.items():
        mimic = node.find("mimic")
        if mimic is None or node.get("type") not in MOVING:
            continue
        mimics[name] = mimic
        ratio, offset = _number(mimic, "multiplier", 1.0), _number(mimic, "offset", 0.0)
        laws.append(Law(name, mimic.get("joint", ""), ratio, offset))
    follows, locked = [], set()
    for law in resolved(laws):
        node, leader = joints[law.follower], joints.get(law.leader)
        moves = leader is not None and leader.get("type") in MOVING
        if moves and law.ratio != 0.0:
            node.remove(mimics[law.follower])
            follows.append(law)
            continue
        low, high = range_of(node)
        value = law.ratio * _locked_at(law.leader, extras) + law.offset
        lock(node, min(max(value, low), high) if low <= high else value)
        locked.add(law.follower)
        if leader is None:
            node.append(mimics[law.follower])
    for node in joints.values():  # what the YAML locked, and what was fixed in the file
        if node.get("type") not in MOVING and node.get("name") not in locked:
            for mimic in node.findall("mimic"):
                node.remove(mimic)
    return follows, locked


def _locked_at(name: str, extras: Extras) -> float:
    """Return where the YAML locks a joint, zero where it says nothing."""
    if name in extras.locked:
        return extras.locked[name]
    patterns = (v for pattern, v in extras.locked.items() if fnmatchcase(name, pattern))
    return next(patterns, 0.0)


def _number(node: Node, key: str, default: float) -> float:
    text = (node.get(key) or "").strip()
    value = float(text) if DECIMAL.fullmatch(text) else default
    return value if math.isfinite(value) else default
