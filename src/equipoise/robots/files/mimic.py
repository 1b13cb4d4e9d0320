"""Locks joints that a URDF couples by <mimic>: nothing here moves two joints by one motor.

A leader that moved without its followers would be another mechanism than the robot's. So the whole
group is locked where half-sitting has its leader, and that is told.
"""

from __future__ import annotations

import math

from equipoise.robots.files.check_joint import MOVING
from equipoise.robots.files.description import Node
from equipoise.robots.files.extras_schema import Extras
from equipoise.robots.files.supplement import lock, range_of
from equipoise.robots.files.values import DECIMAL


def lock_coupled(tree: Node, extras: Extras) -> set[str]:
    """Lock every joint that follows another, and its leader; return their names.

    What the YAML locked already stays as it is, untold. The others keep their <mimic>, which the
    check tells of.
    Raises: RobotFileError.
    """
    joints = {node.get("name", ""): node for node in tree.findall("joint")}
    leaders: dict[str, float] = {}
    locked: set[str] = set()
    for name, node in joints.items():
        mimic = node.find("mimic")
        if mimic is None:
            continue
        if node.get("type") not in MOVING:  # the YAML locked it by itself: it follows nothing
            node.remove(mimic)
            continue
        leader = mimic.get("joint", "")
        value = leaders.setdefault(leader, _posture(leader, joints.get(leader), extras))
        follows = _number(mimic, "multiplier", 1.0) * value + _number(mimic, "offset", 0.0)
        _lock(node, follows)
        node.append(mimic)
        locked.add(name)
    for leader, value in leaders.items():
        led = joints.get(leader)
        if led is not None and led.get("type") in MOVING:
            _lock(led, value)
            locked.add(leader)
    return locked


def _posture(name: str, node: Node | None, extras: Extras) -> float:
    """Return where a leader is at half-sitting, or locked; zero or the nearest it can have."""
    for given in (extras.locked, extras.half_sitting or {}):
        if name in given:
            return given[name]
    return _within(node, 0.0) if node is not None and node.get("type") in MOVING else 0.0


def _lock(node: Node, value: float) -> None:
    lock(node, _within(node, value))


def _within(node: Node, value: float) -> float:
    low, high = range_of(node)
    return min(max(value, low), high) if low <= high else value


def _number(node: Node, key: str, default: float) -> float:
    text = (node.get(key) or "").strip()
    value = float(text) if DECIMAL.fullmatch(text) else default
    return value if math.isfinite(value) else default
