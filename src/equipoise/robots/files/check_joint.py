"""Checks one <joint>: type, axis, limits; returns a clean copy for Pinocchio."""

from __future__ import annotations

import math

from equipoise.robots.files.description import Node
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

MOVING = {"revolute": ("rad", "N m"), "prismatic": ("m", "N"), "continuous": ("rad", "N m")}
TURNS = 200.0 * math.pi  # [rad] to either side, of a joint that turns without end
KNOWN = (*MOVING, "fixed")
CHILDREN = ("parent", "child", "origin", "axis", "limit", "dynamics", "mimic")
UNUSED = ("safety_controller", "calibration")
FOR_OTHERS = ("dont_collapse",)  # MuJoCo reads it
LARGEST_ANGLE = 4 * math.pi  # [rad]; a wider limit is likely in degrees


def check_joint(report: Report, node: Node, name: str, parent: str, child: str) -> Node:
    """Check a joint and return a clean copy."""
    place = f"joint {name!r}"
    kind = node.get("type", "")
    warn_unknown(report, node, place, ("name", "type", *FOR_OTHERS), (*CHILDREN, *UNUSED))
    clean = element("joint", name=name, type="revolute" if kind == "continuous" else kind)
    clean.append(element("parent", link=parent))
    clean.append(element("child", link=child))
    origin = read_origin(report, node, place)
    clean.extend([] if origin is None else [origin])
    if kind not in KNOWN:
        _refuse_type(report, node, place, kind)
    elif kind in MOVING:
        clean.extend(_checked_axis(report, node, place))
        clean.extend(_checked_limit(report, node, place, kind))
        clean.extend(_checked_dynamics(report, node, place))
    if node.find("mimic") is not None:
        leader = only_child(report, node, place, "mimic")
        other = "another" if leader is None else repr(leader.get("joint", ""))
        report.warning(
            node,
            place,
            f"it follows joint {other} by <mimic>, which does not exist: it is locked",
            remedy="Correct the name of its leader",
        )
    return clean


def _refuse_type(report: Report, node: Node, place: str, kind: str) -> None:
    remedies = {
        "floating": "Leave it out: the root link gets a free base by itself",
        "planar": "Write two prismatic joints and one revolute joint",
    }
    report.error(
        node,
        place,
        "this joint type is not supported" if kind else "the joint has no type",
        given=kind or None,
        remedy=remedies.get(kind, f"Use one of {', '.join(KNOWN)}"),
    )


def _checked_axis(report: Report, node: Node, place: str) -> list[Node]:
    axis = only_child(report, node, place, "axis")
    if axis is None:
        report.warning(node, place, "no <axis>: x is taken", remedy='Write <axis xyz="1 0 0"/>')
        return [element("axis", xyz=(1.0, 0.0, 0.0))]
    xyz = read_numbers(report, axis, place, "xyz", 3)
    if xyz is None:
        return []
    norm = math.hypot(*xyz)
    if norm < 1e-6:
        report.error(axis, place, "the axis is zero", given=axis.get("xyz"), remedy="Name a line")
        return []
    if abs(norm - 1.0) > 1e-3:
        report.warning(axis, place, "the axis is not of length 1", given=axis.get("xyz"))
    return [element("axis", xyz=tuple(x / norm for x in xyz))]


def _checked_limit(report: Report, node: Node, place: str, kind: str) -> list[Node]:
    limit = only_child(report, node, place, "limit", needed=True)
    if limit is None:
        return []
    unit, effort_unit = MOVING[kind]
    warn_unknown(report, limit, place, ("lower", "upper", "velocity", "effort"))
    effort = read_positive(report, limit, place, "effort", effort_unit)
    velocity = read_positive(report, limit, place, "velocity", f"{unit}/s")
    lower: float | None = -TURNS
    upper: float | None = TURNS
    if kind != "continuous" or limit.get("lower") is not None:
        lower = read_number(report, limit, place, "lower")
        upper = read_number(report, limit, place, "upper")
    if kind == "continuous" and lower == upper == 0.0:  # what some exporters write for no limit
        lower, upper = -TURNS, TURNS
    if effort is None or velocity is None or lower is None or upper is None:
        return []
    if lower >= upper:
        report.error(
            limit,
            f"{place}, <limit>",
            f"lower must be below upper [{unit}]",
            given=f"lower {limit.get('lower')}, upper {limit.get('upper')}",
            remedy="Exchange them, or make the joint fixed",
        )
        return []
    if kind == "revolute" and max(abs(lower), abs(upper)) > LARGEST_ANGLE:
        report.warning(
            limit,
            place,
            "limits beyond two turns",
            given=f"lower {limit.get('lower')}, upper {limit.get('upper')}",
            remedy="Angles are in rad: convert them if these are degrees",
        )
    return [element("limit", lower=lower, upper=upper, velocity=velocity, effort=effort)]


def _checked_dynamics(report: Report, node: Node, place: str) -> list[Node]:
    dynamics = only_child(report, node, place, "dynamics")
    if dynamics is None:
        return []
    values = {}
    for key in ("damping", "friction"):
        if dynamics.get(key) is None:
            continue
        value = read_number(report, dynamics, place, key)
        if value is not None and value < 0.0:
            report.error(
                dynamics, f"{place}, {key}", "must not be negative", given=dynamics.get(key)
            )
        values[key] = value or 0.0
    return [element("dynamics", **values)] if values else []
