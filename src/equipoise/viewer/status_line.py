"""One line about the moment: the supervisor's mode, how law, hierarchy and feet are."""

from __future__ import annotations

from html import escape

import viser

from equipoise.analysis.feet_phases import PHASE, PHASES, PLANNED
from equipoise.analysis.report.modes import CONTROL, HIERARCHY, MODES, word_of
from equipoise.viewer.layer import Moment

FEET = ("left foot", "right foot")
WELL = tuple(phase.code for phase in PLANNED)


class StatusLine:
    """Text that is written anew for each moment it is shown; bold where all is not well."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._html = gui.add_html("")

    def show(self, moment: Moment) -> None:
        """Write the line of that moment."""
        self._html.content = status_html(moment)


def status_html(moment: Moment) -> str:
    """Return the line as HTML; a channel that was not logged is left out."""
    mode, status = moment.values.get("mode"), moment.values.get("status")
    parts = []
    if mode is not None:
        parts.append(_part("supervisor", word_of(MODES, mode[0]), mode[0] == 0.0))
    if status is not None:
        parts.append(_part("law", word_of(CONTROL, status[0]), status[0] == 0.0))
        parts.append(_part("hierarchy", word_of(HIERARCHY, status[1]), status[1] == 0.0))
    feet = moment.values.get(PHASE)
    if feet is not None:
        parts += [_part(name, word_of(PHASES, code), code in WELL)
                  for name, code in zip(FEET, feet, strict=True)]  # fmt: skip
    return (
        '<div id="equipoise-status" style="margin: 0.3em 1em; font-size: 0.85em">'
        f"{', '.join(parts)}</div>"
    )


def _part(what: str, word: str, well: bool) -> str:
    colour = "#1a7f37" if well else "#b00020"
    weight = 400 if well else 700
    return f'{what} <span style="color: {colour}; font-weight: {weight}">{escape(word)}</span>'
