"""Figure of the balance: where the centre of mass goes, and what room the reactions have."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from equipoise.analysis.figures.layout import (
    LINE,
    NAMED,
    NUMBERS,
    RIM,
    SIDE,
    Area,
    Row,
    axes_grid,
    axes_height,
    whole,
)
from equipoise.analysis.figures.style import (
    ALARM,
    COLOURS,
    INK,
    SOFT,
    curve_look,
    draw_curve,
    label_time,
    new_figure,
    number,
    styled,
)
from equipoise.analysis.run_context import RunContext
from equipoise.contacts import SoleContact, SupportPolygon
from equipoise.contacts.support_polygon import sole_corners
from equipoise.spatial import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MARGINS = (
    ("normal", "Normal force", 1.0, "N"),
    ("pressure", "Centre of pressure: distance to the sole's edge", 1e3, "mm"),
    ("friction", "Friction: margin of the tangential force", 1.0, "N"),
    ("yaw", "Friction in yaw: margin of the moment", 1.0, "N m"),
)


@styled
def balance_figure(context: RunContext) -> Figure | None:
    """Draw the path of the CoM from above, and the reaction margins; None without either."""
    soles = [name for name in context.run if name.startswith("margin/") and context.has(name)]
    margins = [m for m in _MARGINS if any(m[0] in _labels(context, sole) for sole in soles)]
    seen_from_above = context.has("com") and context.known and context.run["com"].shape[1] >= 2
    seen_from_above = seen_from_above and not _walks(context)  # that is in the figure of the walk
    if context.known and context.setup.polygon is None:  # nothing to fall off
        return None
    if not margins and not seen_from_above:
        return None
    figure = new_figure(13.3, 7.2, _title(context))
    left = right = whole(figure)
    if seen_from_above and margins:
        left, right = Area(left.left, 0.465 * left.right), Area(0.465 * left.right, left.right)
    if seen_from_above:
        rows = [Row(below=NAMED + 2.5 * LINE)]
        _draw_from_above(axes_grid(figure, left, [SIDE], rows)[0][0], context)
    if margins:
        rows = [*(Row(below=RIM),) * (len(margins) - 1), Row(below=NAMED + 0.05)]
        column = [row[0] for row in axes_grid(figure, right, [SIDE], rows)]
        for axes, margin in zip(column, margins, strict=True):
            _draw_margin(axes, context, soles, *margin)
            label_time(axes, context.run.t)
        for axes in column[:-1]:
            axes.set_xlabel("")
            axes.tick_params(labelbottom=False)
        last = column[-1]
        drop = NUMBERS / axes_height(last)
        last.legend(loc="upper right", bbox_to_anchor=(1.0, -drop), ncols=4, borderaxespad=0.0)
    return figure


def inset(polygon: SupportPolygon, margin: float) -> Array | None:
    """Return the corners (k, 2) [m] of the polygon moved in by `margin`, None if it vanishes."""
    from scipy.optimize import linprog
    from scipy.spatial import HalfspaceIntersection

    rows = np.column_stack([polygon.normals, np.ones(len(polygon.offsets))])
    bounds = [(None, None), (None, None), (0.0, None)]
    deepest = linprog([0.0, 0.0, -1.0], rows, polygon.offsets - margin, bounds=bounds)
    if deepest.status != 0 or deepest.x[2] <= 1e-9:
        return None
    halfspaces = np.column_stack([polygon.normals, margin - polygon.offsets])
    corners = HalfspaceIntersection(halfspaces, deepest.x[:2]).intersections
    around = np.arctan2(*(corners - deepest.x[:2]).T[::-1])
    return corners[np.argsort(around)]


def _labels(context: RunContext, channel: str) -> tuple[str, ...]:
    return context.run.channels[channel].labels


def _walks(context: RunContext) -> bool:
    """Return whether the run is known to walk: the polygon is then not that of the start."""
    return context.known and context.scenario.walk is not None


def _title(context: RunContext) -> str:
    if not context.has("com_margin") or _walks(context):
        return "Balance"
    margin = context.run["com_margin"][:, 0]
    least = 1e3 * float(margin.min())
    when = context.run.t[int(margin.argmin())]
    where = f"at least {least:.1f} mm inside" if least >= 0.0 else f"up to {-least:.1f} mm outside"
    return f"Balance (centre of mass {where} the support polygon, at {when:.2f} s)"


def _draw_from_above(axes: Axes, context: RunContext) -> None:
    polygon = context.setup.polygon
    assert polygon is not None
    axes.fill(*polygon.vertices.T, facecolor="#F2F5F8", edgecolor=SOFT, label="support polygon")
    for contact in context.setup.contacts.contacts:
        if isinstance(contact, SoleContact):
            corners = sole_corners(contact.sole, contact.T_world_anchor)[:, :2]
            axes.fill(*corners.T, facecolor="#D9DEE4", edgecolor=SOFT, linewidth=0.8)
            x, y = corners[:, 0].min() + 0.004, corners[:, 1].mean()
            name = contact.name.replace("_", " ")
            axes.text(x, y, name, color=SOFT, fontsize=9, ha="left", va="center")
    margin = context.com_margin
    inner = inset(polygon, margin) if margin else None
    if margin is not None and inner is not None:
        closed = np.vstack([inner, inner[:1]])
        axes.plot(
            *closed.T,
            color=ALARM,
            linestyle="--",
            linewidth=1.2,
            label=f"margin {1e3 * margin:g} mm",
        )
    path = context.run["com"][:, :2]
    axes.plot(*path.T, color=COLOURS[0], linewidth=2.0, label="centre of mass")
    axes.plot(*path[0], "o", color="none", markeredgecolor=INK, markersize=12, label="start")
    axes.plot(*path[-1], "s", color=INK, markersize=6, label="end")
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_title("Projection of the centre of mass, seen from above")
    axes.set_xlabel("x, forward [m]")
    axes.set_ylabel("y, to the left [m]")
    drop = NAMED / axes_height(axes)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -drop), ncols=3, borderaxespad=0.0)


def _draw_margin(
    axes: Axes,
    context: RunContext,
    soles: list[str],
    kind: str,
    title: str,
    scale: float,
    unit: str,
) -> None:
    t, least, when = context.run.t, np.inf, 0.0
    for k, name in enumerate(name for name in soles if kind in _labels(context, name)):
        values = scale * context.run[name][:, _labels(context, name).index(kind)]
        label = name.removeprefix("margin/").replace("_", " ")
        draw_curve(axes, t, values, label=label, **curve_look(k, dashed=k % 2 == 1))
        if values.min() < least:
            least, when = float(values.min()), float(t[values.argmin()])
    axes.axhline(0.0, color=ALARM, linewidth=1.2, linestyle="--")
    smallest = f"smallest: {number(least, '.3g')} {unit}" if np.isfinite(least) else "none"
    axes.set_title(f"{title} ({smallest} at {when:.2f} s)", color=INK if least >= 0.0 else ALARM)
    axes.set_ylabel(f"[{unit}]")
    low, high = axes.get_ylim()
    axes.set_ylim(min(low, -0.08 * high), high)
