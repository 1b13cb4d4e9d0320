"""Why runs were not good: a bar for each controller, a part for each cause."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from equipoise.analysis.figures.style import COLOURS
from equipoise.studies.compare.figures.looks import HATCHES, looks_of
from equipoise.studies.compare.tables import causes_of
from equipoise.studies.results import Results

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def can_draw(results: Results) -> bool:
    """Say whether any run was not good."""
    return bool(causes_of(results))


def draw(axes: Axes, results: Results) -> None:
    """Draw how often each cause was met."""
    looks = looks_of(results)
    left = np.zeros(len(looks))
    for k, (cause, counts) in enumerate(causes_of(results).items()):
        widths = np.array([counts.get(name, 0) for name in looks], float)
        axes.barh(
            range(len(looks)), widths, left=left, height=0.6, label=cause,
            color=COLOURS[k % len(COLOURS)], hatch=HATCHES[k % len(HATCHES)],
            edgecolor="white", linewidth=0.6,
        )  # fmt: skip
        left += widths
    axes.set_yticks(range(len(looks)), [look.title for look in looks.values()])
    axes.set_ylim(len(looks) - 0.5, -0.5)
    axes.grid(visible=False, axis="y")
    axes.set_xlabel("runs that were not good")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.24), ncols=2)
    axes.set_title("Causes of failure")
