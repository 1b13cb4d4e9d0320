"""Looks for what a URDF's tree says and nothing reads: unknown top elements, left-over xacro."""

from __future__ import annotations

import re
from collections.abc import Iterator

from equipoise.errors import quoted
from equipoise.robots.files.description import Node
from equipoise.robots.files.values import Report

READ = ("link", "joint", "material")
# Others read these; they say nothing of the robot's body.
FOR_OTHERS = ("gazebo", "transmission", "ros2_control", "sensor", "mujoco", "drake", "group_state")
XACRO = "xacro"
EXPRESSION = re.compile(r"\$\{|\$\(")
REMEDY = "Expand it first: xacro FILE.xacro > FILE.urdf"
SAID_AT_MOST = 5


def check_top(report: Report, tree: Node) -> None:
    """Report left-over xacro as errors, and warn of top elements that are not read."""
    prefixes = xacro_prefixes(tree)
    for node in tree:
        if is_macro(node, prefixes) or (node.tag not in READ and not _is_for_others(node)):
            _check_unknown(report, node, prefixes)
    left = list(_left_over(tree, prefixes))
    for node, place, problem, given in left[:SAID_AT_MOST]:
        report.error(node, place, problem, given=given, remedy=REMEDY)
    if len(left) > SAID_AT_MOST:
        problem = f"{len(left) - SAID_AT_MOST} more pieces of xacro are left over"
        report.error(tree, "robot", problem, remedy=REMEDY)


def xacro_prefixes(tree: Node) -> tuple[str, ...]:
    """Return the prefixes that stand for xacro in a file, each with its colon."""
    own = [
        key.partition(":")[2] + ":"
        for node in tree.iter()
        for key, value in node.items()
        if key.startswith("xmlns:") and XACRO in value.lower()
    ]
    return tuple({f"{XACRO}:", *own})


def is_macro(node: Node, prefixes: tuple[str, ...]) -> bool:
    """Say whether an element is xacro's."""
    return str(node.tag).startswith(prefixes)


def _is_for_others(node: Node) -> bool:
    return str(node.tag).partition(":")[0] in FOR_OTHERS


def _check_unknown(report: Report, node: Node, prefixes: tuple[str, ...]) -> None:
    """Warn of a top element that nothing reads, and of the links and joints that are lost in it."""
    if is_macro(node, prefixes):
        return  # an error already
    tag = str(node.tag)
    inside = [one for one in node.iter() if one is not node]
    lost = ", ".join(
        f"{count} {name}{'' if count == 1 else 's'}"
        for name in ("link", "joint")
        if (count := sum(str(one.tag).lower() == name for one in inside))
    )
    remedy = f"Known here: {', '.join(READ)}"
    if tag.lower() in READ:
        remedy = f"Write it in small letters: <{tag.lower()}>"
    elif lost:
        remedy = "Write links and joints directly inside <robot>"
    elif tag.lower() == "include":
        remedy = "A URDF includes nothing: write the parts into one file"
    what = f", with {lost} in it" if lost else ""
    report.warning(
        node, "robot", f"the element {quoted(tag)} of <robot> is not read{what}", remedy=remedy
    )


def _left_over(
    tree: Node, prefixes: tuple[str, ...]
) -> Iterator[tuple[Node, str, str, str | None]]:
    """Yield where xacro is left over: element, place, problem, and what was given."""
    waiting = [(tree, "robot")]
    while waiting:
        node, place = waiting.pop()
        if is_macro(node, prefixes):
            yield node, place, f"<{node.tag}> is left over from xacro: it makes nothing", None
            continue
        for key, value in node.items():
            if EXPRESSION.search(value):
                problem = f"<{node.tag} {key}> holds an expression of xacro"
                yield node, place, problem, value
        text = (node.text or "").strip()
        if EXPRESSION.search(text):
            yield node, place, f"<{node.tag}> holds an expression of xacro", text
        within = node.get("name")
        inner = f"{node.tag} {quoted(within)}" if node.tag in READ[:2] and within else place
        waiting += [(child, inner) for child in reversed(list(node)) if not _is_for_others(child)]
