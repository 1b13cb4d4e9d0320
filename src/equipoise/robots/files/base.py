"""Finds out whether a URDF's first link moves: as the YAML or the caller says, or as the file does.

A URDF has no word for it. Two habits are understood: a first link called `world` is the world, and
a joint of type `floating` below a first link without mass says that the next one moves freely.
"""

from __future__ import annotations

from equipoise.errors import InputError
from equipoise.robots.base import BASES, FIXED, FLOATING, Base
from equipoise.robots.files.description import Node

WORLD = "world"


def take_base(tree: Node, wanted: str | None) -> tuple[Node, Base]:
    """Return the tree without its joint of type `floating`, and the kind of its base.

    `wanted` decides if it is not None.
    Raises: InputError for a kind that does not exist.
    """
    if wanted is not None and wanted not in BASES:
        raise InputError("There is no base of this kind", given=wanted, known=BASES)
    links = {node.get("name", ""): node for node in tree.findall("link")}
    joints = tree.findall("joint")
    roots = [name for name in links if name not in {_end(joint, "child") for joint in joints}]
    below = [joint for joint in joints if _end(joint, "parent") in roots]
    floats = len(roots) == 1 and len(below) == 1 and below[0].get("type") == FLOATING.kind
    if floats and not list(links[roots[0]]):
        tree.remove(links[roots[0]])
        tree.remove(below[0])
    if wanted is not None:
        return tree, BASES[wanted]
    return tree, FIXED if roots == [WORLD] and not floats else FLOATING


def _end(joint: Node, tag: str) -> str:
    node = joint.find(tag)
    return "" if node is None else node.get("link", "")
