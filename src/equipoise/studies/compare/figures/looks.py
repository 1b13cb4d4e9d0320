"""How controllers look in every figure, so that they can be told apart in print without colour."""

from __future__ import annotations

from dataclasses import dataclass

from equipoise.analysis.figures.style import COLOURS
from equipoise.studies.results import Results

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
