"""Reads the two facts we use of an SRDF: named postures and the collision pairs to leave out."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path

from equipoise.errors import RobotFileError
from equipoise.robots.files.check_top import EXPRESSION, REMEDY, is_macro, xacro_prefixes
from equipoise.robots.files.description import Node, read_description


@dataclass(frozen=True)
class Semantics:
    """Named postures (joint -> angle) and pairs of links whose collisions are not looked at."""

    postures: dict[str, dict[str, float]] = field(default_factory=dict)
    disabled_pairs: tuple[tuple[str, str], ...] = ()


def read_srdf(path: Path) -> Semantics:
    """Read an SRDF file. A joint with several values (the base's pose) is left out.

    Raises: RobotFileError.
    """
    root = read_description(path)
    prefixes = xacro_prefixes(root)
    for node in root.iter():
        if is_macro(node, prefixes) or any(
            EXPRESSION.search(value) for value in node.attrib.values()
        ):
            raise RobotFileError(
                f"{path}, line {node.line}: <{node.tag}> is left over from xacro", remedy=REMEDY
            )
    base = {node.get("name", "") for node in root.iter("virtual_joint")}
    postures = {
        _attribute(path, state, "name"): _angles(path, state, base)
        for state in root.iter("group_state")
    }
    pairs = tuple(
        (_attribute(path, node, "link1"), _attribute(path, node, "link2"))
        for node in root.iter("disable_collisions")
    )
    return Semantics(postures, pairs)


def _angles(path: Path, state: Node, base: set[str]) -> dict[str, float]:
    angles = {}
    for node in state.iter("joint"):
        name, text = _attribute(path, node, "name"), _attribute(path, node, "value")
        if name in base or name == "root_joint" or len(text.split()) > 1:
            continue
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise RobotFileError(
                f"{path}, line {node.line}: the value of joint {name!r} is not a finite number",
                given=text,
                remedy="Write an angle [rad] or a length [m]",
            )
        angles[name] = value
    return angles


def _attribute(path: Path, node: Node, key: str) -> str:
    value = node.get(key)
    if not value:
        raise RobotFileError(f"{path}, line {node.line}: <{node.tag}> needs a {key}")
    return value
