"""Checks a whole URDF tree before Pinocchio sees it: names, one root, no loops, then every part."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from equipoise.errors import quoted
from equipoise.robots.base import FLOATING, Base
from equipoise.robots.files.check_joint import MOVING, check_joint
from equipoise.robots.files.check_link import CheckedLink, check_link, read_colour
from equipoise.robots.files.check_top import check_top
from equipoise.robots.files.description import Node
from equipoise.robots.files.finding import Finding
from equipoise.robots.files.meshes import MeshFolders
from equipoise.robots.files.values import Report, element, only_child

MAX_JOINTS = 500  # Pinocchio crashes on very long chains (seen with 5,000 joints)
MAX_DEPTH = 200
MAX_NAME = 200
HEAVIEST, HEAVIEST_ROBOT, LIGHTEST = 500.0, 2000.0, 1e-5  # [kg] beyond these a mass is absurd
RESERVED = ("universe", "root_joint")


def check_tree(
    tree: Node, path: Path, package_dirs: Sequence[str | Path] = (), base: Base = FLOATING
) -> tuple[Node, list[Finding]]:
    """Return a clean copy of a URDF tree and what was found.

    The copy holds only what was checked (links, joints, shapes, colours), with numbers rewritten
    exactly and mesh paths made absolute. With a fixed `base` the first link needs no
    mass. Use the copy only if no finding is an error.
    """
    report = Report()
    check_top(report, tree)
    own = tree.get("name", "")
    if not own.isprintable() or len(own) > MAX_NAME:
        report.error(tree, "robot", "its name is not printable, or too long", given=own)
    links = _named(report, tree, "link")
    joints = _named(report, tree, "joint")
    if len(joints) > MAX_JOINTS:
        report.error(tree, "robot", f"{len(joints)} joints, at most {MAX_JOINTS} are allowed")
        return tree, report.findings
    ends = {name: _ends(report, node, name, links) for name, node in joints.items()}
    if report.has_errors or not _is_one_tree(report, tree, links, joints, ends):
        return tree, report.findings

    clean = element("robot", name=tree.get("name") or path.stem)
    moving = {child for name, (_, child) in ends.items() if joints[name].get("type") in MOVING}
    if base is FLOATING:
        moving |= {name for name in links if name not in {child for _, child in ends.values()}}
    meshes, colours = MeshFolders(path, package_dirs), _colours(report, tree)
    checked = {
        name: check_link(report, node, name, meshes=meshes, colours=colours)
        for name, node in links.items()
    }
    clean.extend(link.clean for link in checked.values())
    clean.extend(check_joint(report, joints[n], n, *ends[n]) for n in joints)
    if not report.has_errors:
        _check_moving_masses(report, links, ends, moving, checked)
    return clean, report.findings


def _named(report: Report, tree: Node, tag: str) -> dict[str, Node]:
    """Return the links or joints by name; report bad and repeated names."""
    nodes = tree.findall(tag)
    for node in nodes:
        name = node.get("name", "")
        if not name or not name.isprintable() or name != name.strip() or len(name) > MAX_NAME:
            report.error(
                node, f"<{tag}>", "needs a printable name", given=name[:MAX_NAME], remedy="Name it"
            )
        if name in RESERVED:
            report.error(node, f"{tag} {name!r}", "the name is reserved", remedy="Rename it")
    counts = Counter(node.get("name", "") for node in nodes)
    for node in nodes:
        name = node.get("name", "")
        if counts.pop(name, 0) > 1:
            report.error(
                node, f"{tag} {quoted(name)}", "the name is given twice", remedy="Rename one"
            )
    if tag == "link" and not nodes:
        report.error(tree, "robot", "there is no link")
    return {node.get("name", ""): node for node in nodes}


def _ends(report: Report, node: Node, name: str, links: dict[str, Node]) -> tuple[str, str]:
    """Return a joint's parent and child link; report those that do not exist."""
    found = []
    for tag in ("parent", "child"):
        end = only_child(report, node, f"joint {name!r}", tag, needed=True)
        link = "" if end is None else end.get("link", "")
        if end is not None and link not in links:
            report.error(end, f"joint {name!r}", f"its {tag} link does not exist", given=link)
        found.append(link)
    return found[0], found[1]


def _is_one_tree(
    report: Report,
    tree: Node,
    links: dict[str, Node],
    joints: dict[str, Node],
    ends: dict[str, tuple[str, str]],
) -> bool:
    """Check that every link but one root has one parent, all hang on the root, none too deep."""
    parents = Counter(child for _, child in ends.values())
    for name, (_, child) in ends.items():
        if parents[child] > 1:
            report.error(
                joints[name],
                f"link {child!r}",
                f"it has {parents[child]} parent joints",
                remedy="A tree has one; close loops by contacts instead",
            )
    roots = [name for name in links if name not in parents]
    if len(roots) != 1:
        report.error(
            tree,
            "robot",
            f"{len(roots)} root links, wanted 1",
            given=", ".join(roots[:5]) or "every link has a parent: a loop",
            remedy="Connect the parts by joints",
        )
    if report.has_errors:
        return False
    reached, depth = _walk(roots[0], ends)
    if depth > MAX_DEPTH:
        report.error(tree, "robot", f"a chain of {depth} joints, at most {MAX_DEPTH} are allowed")
    for name in links:
        if name not in reached:
            report.error(links[name], f"link {name!r}", "it hangs on a loop, not on the root")
    return not report.has_errors


def _walk(root: str, ends: dict[str, tuple[str, str]]) -> tuple[set[str], int]:
    """Return the links below a root (itself too) and the number of joints of the longest chain."""
    children: dict[str, list[str]] = {}
    for parent, child in ends.values():
        children.setdefault(parent, []).append(child)
    reached, level, depth = {root}, [root], 0
    while True:
        level = [child for link in level for child in children.get(link, ())]
        if not level:
            return reached, depth
        reached.update(level)
        depth += 1


def _check_moving_masses(
    report: Report,
    links: dict[str, Node],
    ends: dict[str, tuple[str, str]],
    moving: set[str],
    checked: dict[str, CheckedLink],
) -> None:
    """Check that every moving link has mass and inertia, its own or of links fixed to it."""
    fixed_parent = {child: parent for parent, child in ends.values() if child not in moving}
    carried: dict[str, list[CheckedLink]] = {name: [] for name in moving}
    for name, link in checked.items():
        carrier = name
        while carrier not in moving and carrier in fixed_parent:
            carrier = fixed_parent[carrier]
        if link.mass > 0.0 and carrier in carried:  # what is fixed to the world needs no mass
            carried[carrier].append(link)
    for name, link in checked.items():
        if link.mass > HEAVIEST:
            _warn_of_mass(report, links[name], f"link {name!r}", link.mass)
    total = sum(link.mass for link in checked.values())
    if total > HEAVIEST_ROBOT:
        _warn_of_mass(report, links[next(iter(links))], "robot", total)
    for name, masses in carried.items():
        place = f"link {name!r}"
        if masses and (mass := sum(one.mass for one in masses)) < LIGHTEST:
            _warn_of_mass(report, links[name], place, mass)
        if not masses:
            remedy = "Add an <inertial>, or make its joint fixed"
            report.error(links[name], place, "a moving link without mass", remedy=remedy)
        elif len(masses) == 1 and not masses[0].has_full_inertia:
            remedy = "Give the principal moments of a body with extent in all directions"
            report.error(links[name], place, "the inertia is not positive definite", remedy=remedy)


def _warn_of_mass(report: Report, node: Node, place: str, mass: float) -> None:
    remedy = "Masses are in kg: convert them if these are grams or tonnes"
    report.warning(node, place, f"an absurd mass: {mass:g} kg", remedy=remedy)


def _colours(report: Report, tree: Node) -> dict[str, tuple[float, ...]]:
    """Return the colours of the materials defined beside the links."""
    colours: dict[str, tuple[float, ...]] = {}
    for node in tree.findall("material"):
        name = node.get("name", "")
        rgba = read_colour(report, node, f"material {name!r}")
        if rgba is not None:
            colours.setdefault(name, rgba)
    return colours
