"""Figure of the balance: where the centre of mass goes, and what room the reactions have."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import HalfspaceIntersection

from equipoise.analysis.story import Story
from equipoise.analysis.style import (
    ALARM,
    COLOURS,
    INK,
    SOFT,
    draw_curve,
    label_time,
    new_figure,
    styled,
)
from equipoise.contacts import SoleContact, SupportPolygon
from equipoise.contacts.support import sole_corners
from equipoise.spatial import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MARGINS = (
    ("normal", "Normal force", 1.0, "N"),
    ("pressure", "Centre of pressure to the sole's edge", 1e3, "mm"),
    ("friction", "Friction cone: room of the tangential force", 1.0, "N"),
    ("yaw", "Friction in yaw: room of the moment", 1.0, "N m"),
)


@styled
def balance_figure(story: Story) -> Figure | None:
    """Draw the path of the CoM from above, and the reaction margins; None without either."""
    soles = [name for name in story.run if name.startswith("margin/") and story.has(name)]
    margins = [m for m in _MARGINS if any(m[0] in _labels(story, sole) for sole in soles)]
    seen_from_above = story.has("com") and story.places is not None
    if not margins and not seen_from_above:
        return None
    figure = new_figure(13.3, 7.2, _title(story))
    if seen_from_above and margins:
        left, right = figure.subfigures(1, 2, width_ratios=(1.0, 1.05))
    else:
        left = right = figure
    if seen_from_above:
        _draw_from_above(left.subplots(), story)
    if margins:
        grid = right.subplots(len(margins), 1, sharex=True, squeeze=False)[:, 0]
        for axes, margin in zip(grid, margins, strict=True):
            _draw_margin(axes, story, soles, *margin)
        label_time(grid[-1], story.run.t)
        grid[0].legend(loc="lower left", ncols=4, bbox_to_anchor=(0.45, 1.0), borderaxespad=0.1)
    return figure


def inset(polygon: SupportPolygon, margin: float) -> Array | None:
    """Return the corners (k, 2) [m] of the polygon moved in by `margin`, None if it vanishes."""
    from scipy.optimize import linprog

    rows = np.column_stack([polygon.normals, np.ones(len(polygon.offsets))])
    bounds = [(None, None), (None, None), (0.0, None)]
    deepest = linprog([0.0, 0.0, -1.0], rows, polygon.offsets - margin, bounds=bounds)
    if deepest.status != 0 or deepest.x[2] <= 1e-9:
        return None
    halfspaces = np.column_stack([polygon.normals, margin - polygon.offsets])
    corners = HalfspaceIntersection(halfspaces, deepest.x[:2]).intersections
    around = np.arctan2(*(corners - deepest.x[:2]).T[::-1])
    return corners[np.argsort(around)]


def _labels(story: Story, channel: str) -> tuple[str, ...]:
    return story.run.channels[channel].labels


def _title(story: Story) -> str:
    if not story.has("com_margin"):
        return "Balance"
    margin = story.run["com_margin"][:, 0]
    least = 1e3 * float(margin.min())
    return (
        f"Balance (centre of mass at least {least:.1f} mm inside the support polygon,"
        f" at {story.run.t[int(margin.argmin())]:.2f} s)"
    )


def _draw_from_above(axes: Axes, story: Story) -> None:
    polygon = story.places.polygon
    axes.fill(*polygon.vertices.T, facecolor="#F2F5F8", edgecolor=SOFT, label="support polygon")
    for contact in story.places.contacts.contacts:
        if isinstance(contact, SoleContact):
            corners = sole_corners(contact.sole, contact.T_world_anchor)[:, :2]
            axes.fill(*corners.T, facecolor="#D9DEE4", edgecolor=SOFT, linewidth=0.8)
            axes.text(
                *corners.mean(axis=0),
                contact.name.replace("_", " "),
                color=SOFT,
                fontsize=9,
                ha="center",
                va="center",
                rotation=0,
            )
    margin = story.com_margin
    inner = inset(polygon, margin) if margin else None
    if inner is not None:
        closed = np.vstack([inner, inner[:1]])
        axes.plot(
            *closed.T,
            color=ALARM,
            linestyle="--",
            linewidth=1.2,
            label=f"margin {1e3 * margin:g} mm",
        )
    path = story.run["com"][:, :2]
    axes.plot(*path.T, color=COLOURS[0], linewidth=2.0, label="centre of mass")
    axes.plot(*path[0], "o", color="white", markeredgecolor=INK, markersize=8, label="start")
    axes.plot(*path[-1], "s", color=INK, markersize=7, label="end")
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_title("Projection of the centre of mass, seen from above")
    axes.set_xlabel("x, forward [m]")
    axes.set_ylabel("y, to the left [m]")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.1), ncols=3)


def _draw_margin(
    axes: Axes, story: Story, soles: list[str], kind: str, title: str, scale: float, unit: str
) -> None:
    least = np.inf
    for k, name in enumerate(soles):
        if kind not in _labels(story, name):
            continue
        values = scale * story.run[name][:, _labels(story, name).index(kind)]
        label = name.removeprefix("margin/").replace("_", " ")
        dashes = "-" if k % 2 == 0 else (0, (4, 2))
        draw_curve(
            axes,
            story.run.t,
            values,
            color=COLOURS[k % len(COLOURS)],
            label=label,
            linestyle=dashes,
        )
        least = min(least, float(values.min()))
    axes.axhline(0.0, color=ALARM, linewidth=1.2, linestyle="--")
    axes.set_title(f"{title} (smallest: {least:.3g} {unit})")
    axes.set_ylabel(f"[{unit}]")
    low, high = axes.get_ylim()
    axes.set_ylim(min(low, -0.08 * high), high)
