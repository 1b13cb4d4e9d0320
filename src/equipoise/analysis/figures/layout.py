"""Where axes stand on a figure: margins in inches, known beforehand.

Measuring every text to find the margins takes as long as drawing the figure. What stands around
axes is known here: a title, numbers, the names of both axes, and a legend of so many lines.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HEADER = 0.34  # [inch] of a figure's title
TITLE = 0.34  # above axes that have a title
NUMBERS = 0.30  # below axes without, and
NAMED = 0.52  # with a name of the time axis
SIDE = 0.84  # left of axes with a name and numbers
SIDE_NUMBERS = 0.58  # left of axes with numbers only
RIM = 0.14
LETTER = 0.074  # of the small type
LINE = 0.2
FEW = 5, 7  # numbers along and up, of one of several panels; each costs as much as a curve
HANDLE = 0.55  # a legend's line and what is around it


@dataclass(frozen=True)
class Row:
    """What a row of axes has `above` and `below` it [inch]."""

    above: float = TITLE
    below: float = NAMED


@dataclass(frozen=True)
class Area:
    """A part of a figure: where it begins and ends [inch] from the left, and its top's distance."""

    left: float
    right: float
    top: float = HEADER


def whole(figure: Figure) -> Area:
    """Return the area of the whole figure, under its title."""
    return Area(0.0, float(figure.get_figwidth()))


def axes_grid(
    figure: Figure, area: Area, sides: Sequence[float], rows: Sequence[Row]
) -> list[list[Axes]]:
    """Return rows of axes of one size; `sides` is what each column has on its left [inch].

    All rows reach from the area's top to the bottom of the figure.
    """
    across, high = float(figure.get_figwidth()), float(figure.get_figheight())
    width = (area.right - area.left - RIM * len(sides) - sum(sides)) / len(sides)
    height = (high - area.top - sum(row.above + row.below for row in rows)) / len(rows)
    grid: list[list[Axes]] = []
    bottom = high - area.top
    for row in rows:
        grid.append([])
        bottom -= row.above + height
        left = area.left
        for side in sides:
            left += side
            place = (left / across, bottom / high, width / across, height / high)
            axes = figure.add_axes(place)
            if len(rows) * len(sides) > 1:
                axes.locator_params("x", nbins=FEW[0])
                axes.locator_params("y", nbins=FEW[1])
            grid[-1].append(axes)
            left += width + RIM
        bottom -= row.below
    return grid


def legend_columns(labels: Sequence[str], letters: int) -> int:
    """Return in how many columns a legend fits into that many letters."""
    widest = max((len(label) for label in labels), default=0)
    return max(1, letters // (widest + 5))


def legend_height(labels: Sequence[str], letters: int) -> float:
    """Return how high [inch] a legend of that many letters is."""
    return LINE * -(-len(labels) // legend_columns(labels, letters)) + 0.1


def legend_below(axes: Axes, letters: int, drop: float = NAMED) -> None:
    """Write the legend `drop` [inch] under the axes, in as many columns as fit into the letters."""
    labels = axes.get_legend_handles_labels()[1]
    axes.legend(
        loc="upper center",
        bbox_to_anchor=(0.5, -drop / axes_height(axes)),
        ncols=legend_columns(labels, letters),
        columnspacing=1.0,
        borderaxespad=0.0,
    )


def axes_height(axes: Axes) -> float:
    """Return the height of axes [inch]."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    return float(axes.get_position().height * figure.get_figheight())


def text_width(texts: Sequence[str]) -> float:
    """Return about how wide [inch] the longest of some texts in small type is."""
    return LETTER * max((len(text) for text in texts), default=0)
