"""Effort against error: what precision costs in torque."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from equipoise.studies.compare.figures.looks import looks_of, plain_log
from equipoise.studies.compare.pairs import sampled_rows
from equipoise.studies.compare.units import metric_label, scaled
from equipoise.studies.results import Results

if TYPE_CHECKING:
    from matplotlib.axes import Axes

EFFORT = "torque_effort"


def can_draw(results: Results, metric: str) -> bool:
    """Say whether effort and error were kept, and some runs stand."""
    kept = {f"m.{EFFORT}", f"m.{metric}"} <= set(results.columns)
    return kept and len(_standing(results)) > 0


def draw(axes: Axes, results: Results, metric: str) -> None:
    """Draw the runs of points on which all stand; crosses are quartiles."""
    rows_of, standing = sampled_rows(results), _standing(results)
    effort = scaled(EFFORT, results[f"m.{EFFORT}"])
    error = scaled(metric, results[f"m.{metric}"])
    for name, look in looks_of(results).items():
        rows = rows_of[name][standing]
        x, y = effort[rows], error[rows]
        axes.plot(x, y, look.marker, color=look.colour, markersize=3.5, alpha=0.35)
        low_x, mid_x, high_x = np.nanpercentile(x, (25, 50, 75))
        low_y, mid_y, high_y = np.nanpercentile(y, (25, 50, 75))
        axes.plot([low_x, high_x], [mid_y, mid_y], color=look.colour, linewidth=1.6)
        axes.plot([mid_x, mid_x], [low_y, high_y], color=look.colour, linewidth=1.6)
        axes.plot(
            mid_x, mid_y, look.marker, color=look.colour, markeredgecolor="white", markersize=9,
            label=look.title,
        )  # fmt: skip
    axes.set_yscale("log")
    plain_log(axes.yaxis)
    axes.set_xlabel("effort: torques as shares of their limits, RMS")
    axes.set_ylabel(metric_label(metric))
    axes.legend(loc="best")
    axes.set_title(f"Effort against error ({len(standing)} points where all stand)")


def _standing(results: Results) -> np.ndarray:
    """Return the places of the paired points on which every controller stands."""
    rows_of = sampled_rows(results)
    if not rows_of:
        return np.zeros(0, dtype=int)
    stands = [results["stands"][rows].astype(bool) for rows in rows_of.values()]
    return np.flatnonzero(np.logical_and.reduce(stands))
