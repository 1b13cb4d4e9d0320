"""The forces of the last seconds: what presses under each foot, as wanted and as measured."""

from __future__ import annotations

from collections import deque

import numpy as np
import viser
from viser import uplot

from equipoise.viewer.playing.live import LiveSession
from equipoise.viewer.plot_panel import COLOURS

SECONDS = 10.0  # [s] that are shown
EVERY = 0.1  # [s] of the run between two points
HEIGHT, WIDTH = 260, 360


class ForcePlot:
    """A plot at the left of the page; nothing where nothing carries the robot."""

    def __init__(self, gui: viser.GuiApi, session: LiveSession) -> None:
        self._session = session
        self._names = tuple(session.forces())
        self._points: deque[tuple[float, ...]] = deque(maxlen=round(SECONDS / EVERY))
        self._chart: viser.GuiUplotHandle | None = None
        if not self._names:
            return
        panel = gui.add_panel()
        with panel.add_tab("Forces"):
            self._chart = gui.add_uplot(
                tuple(np.zeros(1) for _ in range(1 + 2 * len(self._names))),
                _series(self._names),
                title="Pressed on the floor [N]",
                scales={"x": uplot.Scale(time=False)},
                height=HEIGHT,
                legend=uplot.Legend(show=True, live=False),
            )
            gui.add_markdown("*Thin: as the law wants it. Thick: as the feet measure it.*")
        panel.dock_left()
        panel.set_width(WIDTH)

    def show(self) -> None:
        """Take in the forces of now, if some time has gone by."""
        if self._chart is None:
            return
        t = self._session.t
        if t <= 0.0:  # nothing was wanted yet
            return
        if self._points and t < self._points[-1][0] + EVERY:
            return
        forces = self._session.forces()
        values = [value for name in self._names for value in forces.get(name, (0.0, 0.0))]
        self._points.append((t, *np.nan_to_num(values)))
        self._chart.data = tuple(np.array(column) for column in zip(*self._points, strict=True))

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
