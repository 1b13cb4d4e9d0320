"""Plots beside the picture, each with a line at the present time."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence

import numpy as np
import viser
from viser import uplot

from equipoise.spatial import Array
from equipoise.viewer.curves import LEAST_SLACK, MOST_CURVES, Plot
from equipoise.viewer.envelope import Envelope
from equipoise.viewer.panels import Panels

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
NOW = "#222222"
FIRST_SHOWN = ("Posture error", "Contact forces", "Distances", "Slack of the levels")
HEIGHT = 165
BELOW, ABOVE = -1.0, 2.0


class PlotPanel:
    """Slots that each show one of `plots`, chosen by the person who looks."""

    def __init__(self, gui: viser.GuiApi, plots: Mapping[str, Plot], envelope: Envelope) -> None:
        self._plots, self._envelope = plots, envelope
        self._first = _first_indices(plots)
        shown = [title for title in FIRST_SHOWN if title in plots]
        self.slots = [Slot(gui, plots, title, self._curves_of) for title in shown]

    def refresh(self, t: float | None = None) -> None:
        """Take what the envelope has gathered since; `t` [s] moves the line there."""
        for slot in self.slots:
            slot.refresh(t)

    def show(self, t: float) -> None:
        """Move the line to time `t` [s]."""
        for slot in self.slots:
            slot.show(t)

    def _curves_of(self, title: str) -> tuple[list[str], Array, Array]:
        plot, start = self._plots[title], self._first[title]
        indices = list(range(start, start + len(plot.curves)))
        if plot.many:
            indices = self._envelope.lowest(indices, MOST_CURVES)
        t, values = self._envelope.of(indices)
        return [plot.curves[i - start].label for i in indices], t, values


def add_plots(
    gui: viser.GuiApi, panels: Panels, plots: Mapping[str, Plot], envelope: Envelope
) -> PlotPanel:
    """Add a panel with plots at the left of the page, which is one of its `panels`."""
    panel = gui.add_panel()
    with panel.add_tab("Plots"), panels.group():
        shown = PlotPanel(gui, plots, envelope)
    panel.dock_left()
    panel.set_width(400)
    return shown


CurvesOf = Callable[[str], tuple[list[str], Array, Array]]


class Slot:
    """One plot and the list it is chosen from."""

    def __init__(
        self, gui: viser.GuiApi, plots: Mapping[str, Plot], title: str, curves_of: CurvesOf
    ) -> None:
        self._gui, self._plots, self._curves_of = gui, plots, curves_of
        self._folder = gui.add_folder(None)
        with self._folder:
            self._choice = gui.add_dropdown("Plot", tuple(plots), initial_value=title)
        self._choice.on_update(lambda _: self.refresh())
        self._now = 0.0
        self._labels: list[str] = []
        self._t, self._values = np.zeros(0), np.zeros((0, 0))
        self._chart: viser.GuiUplotHandle | None = None
        self._charted = ""
        self._lock = threading.RLock()

    def refresh(self, t: float | None = None) -> None:
        """Draw the chosen plot anew from its curves, with the line at `t` [s] or where it was."""
        with self._lock:
            self._now = self._now if t is None else t
            title = self._choice.value
            labels, self._t, values = self._curves_of(title)
            values = without_gaps(self._t, values)
            if self._plots[title].logarithmic:
                values = np.log10(np.maximum(values, LEAST_SLACK))
            self._values = values
            if (title, labels) != (self._charted, self._labels) and self._chart is not None:
                self._chart.remove()
                self._chart = None
            self._charted, self._labels = title, labels
            self.show(self._now)

    def show(self, t: float) -> None:
        """Move the line to time `t` [s]."""
        with self._lock:
            self._now = t
            if not len(self._t):
                return
            times, values, line = with_line(self._t, self._values, t)
            columns = (times, *np.ascontiguousarray(values.T), line)
            if self._chart is None:
                self._chart = self._new_chart(columns)
            else:
                self._chart.data = columns

    def _new_chart(self, columns: tuple[Array, ...]) -> viser.GuiUplotHandle:
        plot = self._plots[self._charted]
        scales = {
            "x": uplot.Scale(time=False),
            "now": uplot.Scale(auto=False, range=(0.0, 1.0)),
        }
        unit = f" [{plot.unit}]" if plot.unit else ""
        unit += ", powers of ten" if plot.logarithmic else ""
        with self._folder:
            return self._gui.add_uplot(
                columns,
                _series(self._labels),
                title=plot.title + unit,
                scales=scales,
                height=HEIGHT,
                legend=uplot.Legend(show=True, live=False),
            )


def with_line(t: Array, values: Array, now: float) -> tuple[Array, Array, Array]:
    """Insert three moments at `now`, so that a vertical line can stand there.

    Returns times (n + 3,), values (n + 3, k) interpolated there, and the line (n + 3,) on a scale
    of its own: `BELOW` its floor 0 but for the moment in the middle, above its ceiling 1.
    """
    at = int(np.searchsorted(t, now))
    beside = values[min(at, len(t) - 1)]
    if 0 < at < len(t):
        share = (now - t[at - 1]) / (t[at] - t[at - 1])
        beside = (1.0 - share) * values[at - 1] + share * values[at]
    rows = np.vstack([values[:at], beside, beside, beside, values[at:]])
    line = np.full(len(t) + 3, BELOW)
    line[at + 1] = ABOVE
    return np.insert(t, at, [now, now, now]), rows, line


def without_gaps(t: Array, values: Array) -> Array:
    """Return values (n, k) with what is not finite interpolated: one NaN blanks a whole chart."""
    filled = values.copy()
    for column in filled.T:
        known = np.isfinite(column)
        column[~known] = np.interp(t[~known], t[known], column[known]) if known.any() else 0.0
    return filled


def _first_indices(plots: Mapping[str, Plot]) -> dict[str, int]:
    first, count = {}, 0
    for title, plot in plots.items():
        first[title] = count
        count += len(plot.curves)
    return first


_LINE = uplot.Series(
    label="now", stroke=NOW, width=1, scale="now", points=uplot.Series_Points(show=False)
)


def _series(labels: Sequence[str]) -> tuple[uplot.Series, ...]:
    curves = [
        uplot.Series(label=label, stroke=COLOURS[i % len(COLOURS)], width=1.5)
        for i, label in enumerate(labels)
    ]
    return (uplot.Series(label="t [s]"), *curves, _LINE)
