"""The forces of the last seconds: under each foot and at each hand, as wanted and as measured."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping

import numpy as np
import viser
from viser import uplot

from equipoise.viewer.playing.live import LiveSession
from equipoise.viewer.plot_panel import COLOURS

SECONDS = 10.0  # [s] that are shown
EVERY = 0.1  # [s] of the run between two points
ROOM = 1.3  # times the weight is shown: one foot may bear it all, and a load
HAND = 0.2  # times the weight is shown of what a hand lifts
LEAST = 40.0  # [N] that are shown in any case
HEIGHT, WIDTH = 200, 360

Pairs = Mapping[str, tuple[float, float]]


class ForcePlot:
    """Plots at the left of the page: feet, if there are any, and hands on arms of their own."""

    def __init__(self, gui: viser.GuiApi, session: LiveSession) -> None:
        self._session, self._last = session, -np.inf
        self.charts: list[Chart] = []
        weight = 9.81 * session.robot.mass
        feet, hands = session.forces(), session.lifted()
        if not feet and not hands:
            return
        panel = gui.add_panel()
        with panel.add_tab("Forces"):
            if feet:
                top = ROOM * weight
                self.charts.append(Chart(gui, "Pressed on the floor [N]", feet, (0.0, top)))
                gui.add_markdown("*Thin: as the law wants it. Thick: as the feet measure it.*")
            if hands:
                top = max(LEAST, HAND * weight)
                self.charts.append(Chart(gui, "Lifted by the hands [N]", hands, (-top, top)))
                gui.add_markdown("*Thin: what was put there. Thick: what the motors give for it.*")
        panel.dock_left()
        panel.set_width(WIDTH)

    def show(self) -> None:
        """Take in the forces of now, if some time has gone by."""
        t = self._session.t
        if t <= 0.0 or t < self._last + EVERY:  # at first nothing was wanted yet
            return
        self._last = t
        for chart, now in zip(self.charts, self._now(), strict=True):
            chart.show(t, now)

    def clear(self) -> None:
        """Forget what was shown."""
        self._last = -np.inf
        for chart in self.charts:
            chart.clear()

    def _now(self) -> list[Pairs]:
        return [one for one in (self._session.forces(), self._session.lifted()) if one]


class Chart:
    """One plot: by name a thin curve of what is wanted and a thick one of what is."""

    def __init__(
        self, gui: viser.GuiApi, title: str, names: Pairs, shown: tuple[float, float]
    ) -> None:
        self._names = tuple(names)
        self._points: deque[tuple[float, ...]] = deque(maxlen=round(SECONDS / EVERY))
        self.handle = gui.add_uplot(
            tuple(np.zeros(1) for _ in range(1 + 2 * len(self._names))),
            _series(self._names),
            title=title,
            scales={"x": uplot.Scale(time=False), "y": uplot.Scale(range=shown)},
            height=HEIGHT,
            legend=uplot.Legend(show=True, live=False),
        )

    def show(self, t: float, pairs: Pairs) -> None:
        """Add a point at time `t` [s]."""
        values = [value for name in self._names for value in pairs.get(name, (0.0, 0.0))]
        self._points.append((t, *np.nan_to_num(values)))
        self.handle.data = tuple(np.array(column) for column in zip(*self._points, strict=True))

    def clear(self) -> None:
        """Forget what was shown."""
        self._points.clear()


def _series(names: tuple[str, ...]) -> tuple[uplot.Series, ...]:
    series = [uplot.Series(label="t [s]")]
    for k, name in enumerate(names):
        colour = COLOURS[k % len(COLOURS)]
        series.append(uplot.Series(label=f"{name}, wanted", stroke=colour, width=1.0))
        series.append(uplot.Series(label=name, stroke=colour, width=3.0))
    return tuple(series)
