"""How long a tick of motion and control takes, by controller."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from equipoise.studies.compare.figures.looks import looks_of
from equipoise.studies.results import Results

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def can_draw(results: Results) -> bool:
    """Say whether times were measured."""
    return bool(np.isfinite(results.times.get("tick_median_us", np.array([np.nan]))).any())


def draw(axes: Axes, results: Results) -> None:
    """Draw the median over the runs of the median tick, and of its 99th percentile."""
    looks = looks_of(results)
    for k, (name, look) in enumerate(looks.items()):
        mask = results["controller"] == name
        median, tail = (
            float(np.nanmedian(results.times[f"tick_{kind}_us"][mask]))
            for kind in ("median", "p99")
        )
        axes.plot([median, tail], [k, k], color=look.colour, linewidth=1.6)
        axes.plot(median, k, look.marker, color=look.colour, markersize=8)
        axes.plot(tail, k, "|", color=look.colour, markersize=12, mew=2)
    axes.set_yticks(range(len(looks)), [look.title for look in looks.values()])
    axes.set_ylim(len(looks) - 0.5, -0.5)
    axes.set_xlim(left=0.0)
    axes.grid(visible=False, axis="y")
    axes.set_xlabel("a tick [us]: median, and 99th percentile (bar)")
    axes.set_title("Time of a tick")
