"""All faults grown together: which share of the directions is still good at which scale."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from equipoise.studies.compare.boundaries import brackets, survival
from equipoise.studies.compare.figures.looks import looks_of
from equipoise.studies.results import Results

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def designs(results: Results) -> list[str]:
    """Return the designs along all parameters at once."""
    names = results.designs(["boundary"])
    return [n for n in names if getattr(results.study.designs[n], "along", "") == "all"]


def draw(axes: Axes, results: Results, design: str) -> None:
    """Draw a step for each controller, and a band between what is known at least and at most."""
    scales = np.linspace(0.0, 1.0, 201)
    found = brackets(results, design)
    for name, look in looks_of(results).items():
        mine = [one for one in found if one.controller == name]
        if not mine:
            continue
        low, high = survival(mine, scales)
        axes.fill_between(scales, low, high, color=look.colour, alpha=0.18, linewidth=0)
        middle = 0.5 * (low + high)
        axes.plot(
            scales, middle, color=look.colour, linestyle=look.dashes, marker=look.marker,
            markevery=25, label=look.title, markersize=5,
        )  # fmt: skip
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(0.0, 1.03)
    axes.set_xlabel("scale of all faults together")
    axes.set_ylabel("share still good")
    axes.legend(loc="lower left")
    axes.set_title("Survival")
