"""The replay of a run: log, picture, time line, plots and table put together."""

from __future__ import annotations

import threading
import time

import numpy as np

from equipoise.scenarios.read import parse_scenario
from equipoise.simulation.build.setup import Setup, build_setup
from equipoise.viewer.clock import Clock
from equipoise.viewer.curves import plots_of
from equipoise.viewer.display import Display
from equipoise.viewer.envelope import Envelope
from equipoise.viewer.longlog import LongLog
from equipoise.viewer.plain_text import in_markdown
from equipoise.viewer.plot_panel import PlotPanel, add_plots
from equipoise.viewer.server import ViewerServer
from equipoise.viewer.timeline import TimeLine

RATE = 30.0  # [Hz] of the picture
PANEL_PERIOD = 0.2  # [s] between two updates of plots and table while it plays
TRAIL_POINTS = 400
COARSE_PIECES = 150  # how many pieces the first look at a long log takes


class Replay:
    """Shows a log in a guarded server until `stop`; everything is drawn by one thread."""

    def __init__(self, log: LongLog, server: ViewerServer) -> None:
        self.log, self.server = log, server
        scenario = parse_scenario(log.run.scenario_text)
        setup = build_setup(scenario)
        self.clock = Clock(log.t_first, log.t_last)
        gui = server.viser.gui
        self.display = Display(server.viser, scenario, setup)
        with self.display.panels.group():
            self._summary(scenario.title or scenario.name)
            self.timeline = TimeLine(
                gui, self.clock, lambda t: log.before(t).t, lambda t: log.after(t).t
            )
            self.display.add_panels()
        gui.main_panel.dock_right()
        self.plots, self.envelope = self._plots(setup)
        self._stopping = threading.Event()
        self._gathered = threading.Event()
        self._threads = [
            threading.Thread(target=self._draw, name="replay", daemon=True),
            threading.Thread(target=self._gather, name="gathering", daemon=True),
        ]

    def start(self) -> None:
        """Begin to draw."""
        for thread in self._threads:
            thread.start()

    def stop(self) -> None:
        """End drawing; the server is left to its owner."""
        self._stopping.set()
        self.clock.play(False)
        for thread in self._threads:
            thread.join(timeout=5.0)

    def _summary(self, title: str) -> None:
        run, gui = self.log.run, self.server.viser.gui
        lines = [f"**{in_markdown(title)}** — {in_markdown(run.folder.name)}"]
        if run.summary is not None:
            met = "met its acceptance" if run.summary.get("passed") else "did **not** meet it"
            lines.append(f"{in_markdown(run.summary.get('ended', ''))}; {met}")
        if self.log.note:
            lines.append(f"*{in_markdown(self.log.note)}*")
        gui.add_markdown("\n\n".join(lines))

    def _plots(self, setup: Setup) -> tuple[PlotPanel, Envelope]:
        plots = plots_of(self.log.run.channels, setup)
        curves = [curve for plot in plots.values() for curve in plot.curves]
        envelope = Envelope(curves, self.log.t_first, self.log.t_last)
        return add_plots(self.server.viser.gui, self.display.panels, plots, envelope), envelope

    def _draw(self) -> None:
        shown, panels_at, passed = None, -np.inf, time.perf_counter()
        while not self._stopping.is_set():
            now = time.perf_counter()
            self.clock.advance(now - passed)
            passed = now
            if self._gathered.is_set():
                self._gathered.clear()
                self.plots.refresh()
                shown = None
            t = self.clock.t
            if t != shown:
                due = now - panels_at >= PANEL_PERIOD or not self.clock.playing
                self._show(t, panels=due)
                panels_at = now if due else panels_at
                shown = t
            self.timeline.show()
            self.clock.wait(max(0.0, 1.0 / RATE - (time.perf_counter() - now)))

    def _show(self, t: float, *, panels: bool) -> None:
        tick = self.log.at(t)
        moment = self.display.moment(tick.t, tick.values)
        if moment is None:
            return
        self.display.show(moment)
        if panels:
            self.plots.show(tick.t)
            self.display.show_panels(moment)

    def _gather(self) -> None:
        """Look at the whole log, coarsely first, then piece by piece."""
        stride = max(1, -(-self.log.chunk_count // COARSE_PIECES))
        passes = (stride, max(1, stride // 8), 1) if stride > 1 else (1,)
        most = max(1, TRAIL_POINTS // max(1, self.log.chunk_count // stride))
        done = 0
        for number, arrays in self.log.pieces(passes):
            if self._stopping.is_set():
                return
            if number > done:
                done = number
                self._publish()
            self.envelope.add(arrays)
            if number == 0:
                self.display.trails.gather(arrays, most)
            else:
                time.sleep(0.0005)  # the picture comes first
        self._publish()

    def _publish(self) -> None:
        self.display.trails.publish()
        self._gathered.set()
