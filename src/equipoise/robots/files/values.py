"""Reads the numbers of a URDF strictly: plain decimals, finite, of the wanted count and sign."""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass, field

from equipoise.robots.files.description import Node
from equipoise.robots.files.finding import ERROR, WARNING, Finding

DECIMAL = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
LARGEST = 1e12  # squares of it are far from overflow; no length, mass or torque comes near it
LIMIT_SLACK = 1e-6  # [rad or m], the rounding of limits printed with six decimals
SMALLEST = 1e-300  # below this, parsers disagree; taken as zero


@dataclass
class Report:
    """Collect findings."""

    findings: list[Finding] = field(default_factory=list)

    def error(
        self, node: Node, place: str, problem: str, *, given: str | None = None, remedy: str = ""
    ) -> None:
        """Add an error: the description must not be used."""
        self.findings.append(Finding(ERROR, place, problem, remedy, given, node.line))

    def warning(
        self, node: Node, place: str, problem: str, *, given: str | None = None, remedy: str = ""
    ) -> None:
        """Add a warning: usable, but perhaps not what was meant."""
        self.findings.append(Finding(WARNING, place, problem, remedy, given, node.line))

    @property
    def has_errors(self) -> bool:
        """Say whether an error is among the findings."""
        return any(finding.severity == ERROR for finding in self.findings)


def read_numbers(
    report: Report, node: Node, place: str, key: str, count: int
) -> tuple[float, ...] | None:
    """Return `count` finite numbers of an attribute, or None after reporting what is wrong."""
    where = f"{place}, <{node.tag} {key}>"
    text = node.get(key)
    wanted = "a number" if count == 1 else f"{count} numbers"
    if text is None:
        report.error(node, where, "missing", remedy=f"Give {wanted}")
        return None
    words = text.split()
    if len(words) != count:
        report.error(node, where, f"wanted {wanted}, got {len(words)}", given=text)
        return None
    values = []
    for word in words:
        value = float(word) if DECIMAL.fullmatch(word) else float("nan")
        if not abs(value) <= LARGEST:
            problem = f"too large (above {LARGEST:g})" if value == value else "not a finite number"
            report.error(
                node, where, problem, given=text, remedy=f"Give {wanted}, like 0.5 or 1e-3"
            )
            return None
        values.append(value if abs(value) >= SMALLEST else 0.0)
    return tuple(values)


def read_number(report: Report, node: Node, place: str, key: str) -> float | None:
    """Return one finite number of an attribute, or None after reporting what is wrong."""
    values = read_numbers(report, node, place, key, 1)
    return None if values is None else values[0]


def read_positive(report: Report, node: Node, place: str, key: str, unit: str) -> float | None:
    """Return one number above zero, or None after reporting what is wrong."""
    value = read_number(report, node, place, key)
    if value is None or value > 0.0:
        return value
    report.error(
        node,
        f"{place}, <{node.tag} {key}>",
        "must be positive",
        given=node.get(key),
        remedy=f"Give the true value [{unit}]",
    )
    return None


def only_child(
    report: Report, node: Node, place: str, tag: str, *, needed: bool = False
) -> Node | None:
    """Return the child of a tag; report it if it is there twice, or missing though needed."""
    found = node.findall(tag)
    if len(found) > 1:
        report.error(found[1], place, f"<{tag}> is given {len(found)} times", remedy="Keep one")
    if not found and needed:
        report.error(node, place, f"<{tag}> is missing in <{node.tag}>", remedy="Add it")
    return found[0] if found else None


def warn_unknown(
    report: Report,
    node: Node,
    place: str,
    attributes: Collection[str],
    children: Collection[str] = (),
) -> None:
    """Warn of attributes and child elements that nothing reads: often a slip of the pen."""
    for kind, names, known in (
        ("attribute", node.keys(), attributes),
        ("element", {child.tag for child in node}, children),
    ):
        for name in sorted(set(names) - set(known)):
            report.warning(
                node,
                place,
                f"the {kind} {name!r} of <{node.tag}> is not read",
                remedy=f"Known here: {', '.join(known) or 'none'}",
            )


def element(tag: str, **attributes: object) -> Node:
    """Return a new element with numbers written so that they are read back exactly."""
    return Node(tag, {key: _written(value) for key, value in attributes.items()})


def read_origin(report: Report, node: Node, place: str) -> Node | None:
    """Return a clean <origin> of an element, or None if there is none."""
    origin = only_child(report, node, place, "origin")
    if origin is None:
        return None
    warn_unknown(report, origin, place, ("xyz", "rpy"))
    attributes = {}
    for key in ("xyz", "rpy"):
        if origin.get(key) is not None:
            attributes[key] = read_numbers(report, origin, place, key, 3) or (0.0, 0.0, 0.0)
    return element("origin", **attributes)


def _written(value: object) -> str:
    if isinstance(value, tuple):
        return " ".join(repr(float(x)) for x in value)
    return repr(float(value)) if isinstance(value, (int, float)) else str(value)
