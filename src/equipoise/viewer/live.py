"""The page's side of the live viewer: draws the ticks of a running simulation, sends request."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np

from equipoise.errors import EquipoiseError
from equipoise.runlog import Channel
from equipoise.scenarios.read import parse_scenario
from equipoise.simulation.build.setup import build_setup
from equipoise.spatial import Array
from equipoise.viewer.curves import plots_of
from equipoise.viewer.display import Display
from equipoise.viewer.envelope import Envelope
from equipoise.viewer.layer import Moment
from equipoise.viewer.longlog import LongLog
from equipoise.viewer.operator_panel import OperatorPanel
from equipoise.viewer.page_ready import has_begun_frame
from equipoise.viewer.plain_text import in_markdown
from equipoise.viewer.plot_panel import add_plots
from equipoise.viewer.replay import PANEL_PERIOD, Replay
from equipoise.viewer.server import ViewerServer

IN_FLIGHT = 2  # ticks on their way at most, so that the pipe never fills and nothing waits
PLOT_PERIOD = 0.5  # [s] between two updates of the plots, which cost a page as much as a picture
SLOWEST = 0.25  # [s] that a page may take for a picture before the next is sent all the same
BACKGROUND = 5  # niceness: where cores are short, the control loop comes before its picture


@dataclass(frozen=True)
class Job:
    """What the process that serves the page is told: where, and what will be logged."""

    scenario_text: str
    channels: tuple[Channel, ...]
    push_frame: str
    host: str
    port: int | None


def serve(pipe: Connection, job: Job) -> None:
    """Serve the page of a running simulation until the pipe ends (a process of its own)."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the run, which then closes this
    os.nice(BACKGROUND)
    try:
        server = ViewerServer(job.host, job.port)
    except EquipoiseError as error:
        pipe.send(("error", str(error)))
        return
    try:
        live = LiveView(pipe, server, job)
        pipe.send(("url", server.url))
        live.run()
    except (EOFError, OSError):
        pass  # the run has ended without a word
    finally:
        server.stop()


class LiveView:
    """Shows what comes through the pipe; one thread draws, viser's threads send request."""

    def __init__(self, pipe: Connection, server: ViewerServer, job: Job) -> None:
        self._pipe, self.server = pipe, server
        scenario = parse_scenario(job.scenario_text)
        setup = build_setup(scenario)
        self._sending = threading.Lock()
        self._names = [channel.name for channel in job.channels]
        self._ends = np.cumsum([channel.size for channel in job.channels])[:-1]
        gui = server.viser.gui
        self.display = Display(server.viser, scenario, setup)
        with self.display.panels.group():
            gui.add_markdown(f"**{in_markdown(scenario.title or scenario.name)}** — running")
            self.panel = OperatorPanel(gui, scenario, setup, job.push_frame, self._send)
            self.display.add_panels()
        gui.main_panel.dock_right()
        plots = plots_of({channel.name: channel for channel in job.channels}, setup)
        curves = [curve for plot in plots.values() for curve in plot.curves]
        self._envelope = Envelope(curves, 0.0, scenario.duration)
        self._plots = add_plots(gui, self.display.panels, plots, self._envelope)
        self._panels_at = self._plots_at = -np.inf
        self._unwritten: Moment | None = None
        self._replay: Replay | None = None
        server.viser.on_client_connect(lambda _: self._welcome())

    def run(self) -> None:
        """Draw until the run says that the page is to close. Raises: `EOFError`, `OSError`."""
        while True:
            if not self._pipe.poll(PANEL_PERIOD):
                self._write(plots=True)  # the run stands: the panels may lag behind the picture
            kind, content = self._pipe.recv()
            if kind == "tick":
                self.show(float(content[0]), self._split(content[1:]))
                self._wait_for_page()
                self._send("ready", None)
            elif kind == "finished":
                self._show_replay(Path(content))
            elif kind == "close":
                if self._replay is not None:
                    self._replay.stop()
                return

    def show(self, t: float, values: Mapping[str, Array]) -> None:
        """Draw a tick."""
        moment = self.display.moment(t, values)
        if moment is None:
            return
        self.display.trails.add(moment)
        self.display.show(moment)
        self._envelope.add({"t": np.array([t]), **{k: v[None] for k, v in values.items()}})
        self._unwritten = moment
        now = time.perf_counter()
        if now - self._panels_at >= PANEL_PERIOD:
            self._panels_at = now
            self._write(plots=now - self._plots_at >= PLOT_PERIOD)

    def _write(self, *, plots: bool) -> None:
        """Let the panels say what the last picture shows, unless they do."""
        if self._unwritten is None:
            return
        moment = self._unwritten
        self.panel.show(moment.t)
        self.display.show_panels(moment)
        if plots:
            self._plots_at, self._unwritten = time.perf_counter(), None
            self._plots.refresh(moment.t)

    def _wait_for_page(self) -> None:
        """Wait until the page has taken the picture in: more than it can draw is wasted."""
        for client in list(self.server.viser.get_clients().values())[:1]:
            has_begun_frame(client, SLOWEST)

    def _welcome(self) -> None:
        for _ in range(IN_FLIGHT):
            self._send("ready", None)

    def _split(self, numbers: Array) -> dict[str, Array]:
        """Return the values of a tick by channel."""
        return dict(zip(self._names, np.split(numbers, self._ends), strict=True))

    def _show_replay(self, folder: Path) -> None:
        """Give the same page to the finished run."""
        viser = self.server.viser
        self.display.progressive.end()
        self._unwritten = None
        viser.gui.reset()
        viser.scene.reset()
        try:
            self._replay = Replay(LongLog(folder), self.server)
            self._replay.start()
        except EquipoiseError as error:
            viser.gui.add_markdown(in_markdown(error))

    def _send(self, kind: str, content: object) -> None:
        with self._sending:
            self._pipe.send((kind, content))
