"""The simulation's side of the live viewer: a pipe to the process that draws.

The page is served by a process of its own, so that drawing costs the loop next to nothing: 30
times a second it hands over one tick, unless the page is still busy with the last ones.
"""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Mapping
from contextlib import suppress
from multiprocessing.process import BaseProcess
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from equipoise.errors import EquipoiseError
from equipoise.scenarios.read import resolved_text
from equipoise.simulation.controlled_run import ControlledRun
from equipoise.simulation.operator import OperatorRequest, StopRequested
from equipoise.spatial import Array
from equipoise.viewer.base_link import base_link
from equipoise.viewer.live import IN_FLIGHT, Job, serve

RATE = 30.0  # [Hz] at which ticks are handed over
LISTEN_PERIOD = 0.015  # [s] between two looks for request
START_TIMEOUT = 120.0  # [s] for the page to be served
FIRST_PAGE_TIMEOUT = 60.0  # [s] that the run waits for somebody to look


class Bridge:
    """Steers a simulation from the page; a lost page lets the run go on alone."""

    def __init__(self, simulation: ControlledRun, host: str, port: int | None) -> None:
        channels = tuple(simulation.channels)
        self._names = [channel.name for channel in channels]
        job = Job(
            resolved_text(simulation.scenario),
            channels,
            base_link(simulation.robot),
            host,
            port,
        )
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self.process: BaseProcess = context.Process(
            target=serve, args=(theirs, job), name="live viewer", daemon=True
        )
        self.process.start()
        theirs.close()
        self.paused_s = 0.0
        self._connected = True
        self._running, self._allowed = True, 0
        self._wanted = 0  # how many ticks the page can take
        self._stop = False
        self._news: OperatorRequest | None = None
        self._looked = self._told = 0.0
        self._untold: tuple[float, Mapping[str, Array]] | None = None
        self.url = self._first_answer()

    def wait_for_page(self, say: Callable[[str], None]) -> None:
        """Wait until somebody looks, but not for ever."""
        began = perf_counter()
        while self._connected and not self._wanted:
            if perf_counter() - began > FIRST_PAGE_TIMEOUT:
                say("Nobody looks yet; the run begins.")
                return
            self._listen(0.1)

    def before_tick(self, t: float) -> OperatorRequest | None:
        """Return new request; wait while the page says pause."""
        now = perf_counter()
        if now - self._looked >= LISTEN_PERIOD:
            self._looked = now
            self._listen(0.0)
        if not self._running:
            self._pause(now)
        if self._stop:
            raise StopRequested
        news, self._news = self._news, None
        return news

    def after_tick(self, t: float, values: Mapping[str, Array]) -> None:
        """Hand the tick over if one is due and wanted."""
        self._untold = t, values
        if self._wanted and perf_counter() - self._told >= 1.0 / RATE:
            self._tell()

    def finish(self, folder: Path) -> None:
        """Let the page show the finished run."""
        self._send("finished", str(folder))

    def close(self) -> None:
        """Close the page."""
        self._send("close", None)
        self.process.join(timeout=5.0)
        if self.process.is_alive():
            self.process.terminate()
            self.process.join(timeout=5.0)
        if self.process.is_alive():
            self.process.kill()
            self.process.join()

    def _tell(self) -> None:
        """Hand over the last tick, unless that was done."""
        if self._untold is not None:
            t, values = self._untold
            self._untold, self._told = None, perf_counter()
            self._wanted -= 1
            self._send("tick", np.concatenate([[t], *(values[name] for name in self._names)]))

    def _pause(self, began: float) -> None:
        if self._allowed:
            self._allowed -= 1
            return
        while self._connected and not (self._running or self._stop or self._allowed):
            if self._wanted:
                self._tell()  # where it stands, which may be later than what is seen
            self._listen(0.05)
        if self._allowed:
            self._allowed -= 1
        self.paused_s += perf_counter() - began

    def _listen(self, seconds: float) -> None:
        """Take all messages of the page; wait at most that long for the first."""
        try:
            while self._connected and self._pipe.poll(seconds):
                self._take(*self._pipe.recv())
                seconds = 0.0
        except (EOFError, OSError):
            self._lose()

    def _take(self, kind: str, content: Any) -> None:
        if kind == "ready":
            self._wanted = min(self._wanted + 1, IN_FLIGHT)
        elif kind == "request":
            self._news = content
        elif kind == "run":
            self._running = bool(content)
        elif kind == "step":
            self._running, self._allowed = False, int(content)
        elif kind == "stop":
            self._stop = True

    def _first_answer(self) -> str:
        try:
            if self._pipe.poll(START_TIMEOUT):
                kind, content = self._pipe.recv()
                if kind == "url":
                    return str(content)
                raise EquipoiseError(str(content))
        except (EOFError, OSError):
            pass
        raise EquipoiseError("The live viewer did not start; the run was not begun.")

    def _send(self, kind: str, content: Any) -> None:
        if self._connected:
            try:
                self._pipe.send((kind, content))
            except (OSError, ValueError):
                self._lose()

    def _lose(self) -> None:
        self._connected, self._running, self._wanted = False, True, 0
        with suppress(OSError):
            self._pipe.close()
