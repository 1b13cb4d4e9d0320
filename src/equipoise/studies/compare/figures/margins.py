"""The spider of margins: how far each parameter alone can go, as a share of its range."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from equipoise.studies.compare.boundaries import brackets
from equipoise.studies.compare.figures.looks import looks_of
from equipoise.studies.compare.units import spoke_name
from equipoise.studies.results import Results

if TYPE_CHECKING:
    from matplotlib.projections.polar import PolarAxes

FEWEST = 3  # spokes of a spider


def designs(results: Results) -> list[str]:
    """Return the designs along each parameter alone that have enough spokes."""
    names = [
        name
        for name in results.designs(["boundary"])
        if getattr(results.study.designs[name], "along", "") == "each"
    ]
    return [n for n in names if len({b.line.name for b in brackets(results, n)}) >= FEWEST]


def draw(axes: PolarAxes, results: Results, design: str) -> None:
    """Draw a polygon for each controller; the rim is the end of what was tried."""
    found = brackets(results, design)
    spokes = list(dict.fromkeys(one.line.name for one in found))
    angles = np.linspace(0.0, 2.0 * np.pi, len(spokes), endpoint=False)
    for name, look in looks_of(results).items():
        reach = {one.line.name: one.middle for one in found if one.controller == name}
        radii = [reach.get(spoke, np.nan) for spoke in spokes]
        closed = np.append(angles, angles[0]), np.append(radii, radii[0])
        axes.plot(
            *closed, color=look.colour, linestyle=look.dashes, marker=look.marker,
            markersize=5, label=look.title,
        )  # fmt: skip
        axes.fill(*closed, color=look.colour, alpha=0.08)
    axes.set_theta_offset(0.5 * np.pi)
    axes.set_theta_direction(-1)
    axes.set_ylim(0.0, 1.05)
    axes.set_yticks([0.25, 0.5, 0.75, 1.0], ["", "0.5", "", "1"])
    axes.set_xticks(angles, [spoke_name(results.study, spoke) for spoke in spokes])
    for angle, label in zip(angles, axes.get_xticklabels(), strict=True):
        side = np.sin(angle)
        label.set_horizontalalignment(
            "left" if side > 0.1 else "right" if side < -0.1 else "center"
        )
    axes.tick_params(axis="x", pad=1)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=3)
    axes.set_title("Margins, each parameter alone", pad=20, loc="center")
