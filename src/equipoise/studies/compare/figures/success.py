"""How many runs stand and how many are good, with intervals."""

from __future__ import annotations

from typing import TYPE_CHECKING

from equipoise.studies.compare.figures.looks import looks_of
from equipoise.studies.compare.pairs import sampled_rows
from equipoise.studies.compare.statistics import share
from equipoise.studies.results import Results

if TYPE_CHECKING:
    from matplotlib.axes import Axes

APART = 0.16  # of stands and good, in rows


def can_draw(results: Results) -> bool:
    """Say whether there are points that all controllers have run."""
    return any(len(rows) for rows in sampled_rows(results).values())


def draw(axes: Axes, results: Results, baseline: str) -> None:
    """Draw a row for each controller: full marks stand, open marks are good."""
    looks, rows_of = looks_of(results), sampled_rows(results)
    for k, (name, rows) in enumerate(rows_of.items()):
        look = looks[name]
        for what, offset, face in (("stands", -APART, look.colour), ("good", APART, "white")):
            found = share(results[what][rows])
            y = k + offset
            axes.plot([found.low, found.high], [y, y], color=look.colour, linewidth=1.6)
            axes.plot(
                found.value, y, marker=look.marker, color=look.colour, markerfacecolor=face,
                markersize=7,
            )  # fmt: skip
            axes.annotate(
                f"{what} {found.count}/{found.of}", (found.low, y), xytext=(-6, 0),
                textcoords="offset points", ha="right", va="center", fontsize=8,
            )  # fmt: skip
    axes.set_yticks(range(len(rows_of)), [looks[name].title for name in rows_of])
    axes.set_ylim(len(rows_of) - 0.5, -0.5)
    axes.set_xlim(-0.35, 1.03)
    axes.set_xticks([0.0, 0.25, 0.5, 0.75, 1.0])
    axes.grid(visible=False, axis="y")
    axes.set_xlabel("share of the points, 95 % interval")
    axes.set_title("Success")
