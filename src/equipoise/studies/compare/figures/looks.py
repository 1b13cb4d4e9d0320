"""How controllers look in every figure, so that they can be told apart in print without colour."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from equipoise.analysis.figures.style import COLOURS
from equipoise.studies.results import Results

if TYPE_CHECKING:
    from matplotlib.axis import Axis

MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")
DASHES = ("-", (0, (5, 2)), (0, (1, 1.4)), (0, (6, 2, 1, 2)))
HATCHES = ("", "////", "....", "xxxx", "\\\\\\\\", "----", "oooo", "++++")


@dataclass(frozen=True)
class ControllerLook:
    """Colour, marker, dashes, hatching and title of one controller."""

    title: str
    colour: str
    marker: str
    dashes: object
    hatch: str


def plain_log(axis: Axis) -> None:
    """Write the numbers of a logarithmic axis as they are, few of them."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def looks_of(results: Results) -> dict[str, ControllerLook]:
    """Return how each controller looks, in the order of the study."""
    return {
        name: ControllerLook(
            results.study.controllers[name].title or name,
            COLOURS[k % len(COLOURS)],
            MARKERS[k % len(MARKERS)],
            DASHES[k % len(DASHES)],
            HATCHES[k % len(HATCHES)],
        )
        for k, name in enumerate(results.controllers)
    }
