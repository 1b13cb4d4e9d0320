"""Whether a floor could have carried the robot: balance and reactions of the soles."""

from __future__ import annotations

from collections.abc import Callable

from equipoise.analysis.metrics.base import Found, Metric, least
from equipoise.analysis.run_context import RunContext


def _com_margin(context: RunContext) -> Found | None:
    if context.setup.polygon is None or context.scenario.walk is not None:
        return None  # the polygon of the start is not that of a robot that walks
    return least([context.run["com_margin"][:, 0]], ["com"])


def _reaction(kind: str) -> Callable[[RunContext], Found | None]:
    def compute(context: RunContext) -> Found | None:
        margins = context.margins(kind)
        return least(list(margins.values()), list(margins))

    return compute


def _violation(context: RunContext) -> float:
    return float(context.run["violation"].max())


def _slack(context: RunContext) -> float:
    return float(context.run["slack"][:, 0].max())


METRICS = (
    Metric(
        "com_margin",
        "m",
        "least distance of the CoM projection to the edge of the polygon",
        _com_margin,
    ),
    Metric("reaction_normal", "N", "least normal force at a sole", _reaction("normal")),
    Metric("reaction_friction", "N", "least distance to the friction cone", _reaction("friction")),
    Metric(
        "reaction_pressure", "m", "least margin of the centre of pressure", _reaction("pressure")
    ),
    Metric("reaction_yaw", "N m", "least margin of the yaw moment", _reaction("yaw")),
    Metric("contact_violation", "m", "largest contact violation (or rad)", _violation),
    Metric("slack_level0", "", "largest |w| of level 0", _slack),
)
