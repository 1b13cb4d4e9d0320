"""How much others differ from one, pair by pair: violins of one metric."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from equipoise.analysis.figures.style import INK, SOFT
from equipoise.spatial import Array
from equipoise.studies.compare.figures.looks import looks_of
from equipoise.studies.compare.pairs import sampled_rows
from equipoise.studies.compare.units import metric_label, scaled
from equipoise.studies.results import Results

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FEWEST = 3  # pairs of which a violin means something
LINEAR = 90.0  # percentile up to which the axis is linear


def changes(results: Results, baseline: str, metric: str) -> dict[str, Array]:
    """Return by controller the differences (n,) to the baseline where both stand."""
    rows_of, found = sampled_rows(results), {}
    first = rows_of.get(baseline)
    for name, rows in rows_of.items():
        if name == baseline or first is None:
            continue
        both = results["stands"][first].astype(bool) & results["stands"][rows].astype(bool)
        column = scaled(metric, results[f"m.{metric}"])
        change = column[rows[both]] - column[first[both]]
        if np.isfinite(change).sum() >= FEWEST:
            found[name] = change[np.isfinite(change)]
    return found


def can_draw(results: Results, baseline: str, metric: str) -> bool:
    """Say whether there are enough pairs of it."""
    return f"m.{metric}" in results.columns and bool(changes(results, baseline, metric))


def draw(axes: Axes, results: Results, baseline: str, metric: str) -> None:
    """Draw a violin for each other controller; bars are quartiles, dots the pairs."""
    looks, found = looks_of(results), changes(results, baseline, metric)
    everything = np.concatenate(list(found.values()))
    linear = float(np.percentile(np.abs(everything), LINEAR)) or 1.0
    if np.abs(everything).max() > 5.0 * linear:
        axes.set_xscale("symlog", linthresh=linear)
    rng = np.random.default_rng(0)
    for k, (name, change) in enumerate(found.items()):
        look = looks[name]
        if np.ptp(change) > 0.0:
            parts = axes.violinplot(
                change, positions=[k], orientation="horizontal", widths=0.7, showextrema=False
            )
            bodies: Any = parts["bodies"]
            for body in bodies:
                body.set(facecolor=look.colour, alpha=0.28, edgecolor=look.colour, linewidth=0.8)
        y = k + 0.12 * rng.uniform(-1.0, 1.0, len(change))
        axes.plot(change, y, ".", color=look.colour, markersize=3, alpha=0.7)
        low, middle, high = np.percentile(change, (25, 50, 75))
        axes.plot([low, high], [k, k], color=INK, linewidth=3, solid_capstyle="butt")
        axes.plot(middle, k, "o", color="white", markeredgecolor=INK, markersize=6)
    axes.axvline(0.0, color=SOFT, linewidth=0.9)
    axes.set_yticks(range(len(found)), [looks[name].title for name in found])
    axes.set_ylim(len(found) - 0.5, -0.5)
    axes.grid(visible=False, axis="y")
    axes.set_xlabel(metric_label(metric))
    axes.set_title(f"Difference to {looks[baseline].title}, pair by pair")
