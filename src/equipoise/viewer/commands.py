"""What the command line calls: open a page, and keep it open until Ctrl-C."""

from __future__ import annotations

import os
import sys
import threading
import webbrowser
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from equipoise.robots import check_urdf, get_robot, named_robots, robot_path
from equipoise.robots.files.finding import raise_errors
from equipoise.runlog import latest_run
from equipoise.simulation.controlled_run import ControlledRun
from equipoise.viewer.bridge import Bridge
from equipoise.viewer.longlog import LongLog
from equipoise.viewer.playing.page import Play
from equipoise.viewer.playing.plant import Physics, usual_physics
from equipoise.viewer.playing.reference import ReferenceSession
from equipoise.viewer.playing.walking import WalkingSession
from equipoise.viewer.replay import Replay
from equipoise.viewer.robot_view import RobotView
from equipoise.viewer.server import ViewerServer

Say = Callable[[str], None]
RUNS = Path("runs")


def view_run(run_path: Path | None, host: str, port: int | None, say: Say, *, browse: bool) -> None:
    """Show a run (None: the last one under runs/) until Ctrl-C.

    Raises: `RunLogError`, `InputError`.
    """
    log = LongLog(run_path if run_path is not None else latest_run(RUNS))
    server = ViewerServer(host, port)
    try:
        replay = Replay(log, server)
        replay.start()
        if log.note:
            say(f"Note: {log.note}")
        say(f"Showing {log.run.folder} at {server.url}")
        keep_open(server, say, browse=browse)
        replay.stop()
    finally:
        server.stop()


def view_robot(name_or_path: str, host: str, port: int | None, say: Say, *, browse: bool) -> None:
    """Show a robot with its checks until Ctrl-C.

    Raises: `RobotFileError` with every error of a file that cannot be trusted.
    """
    known = name_or_path in named_robots()
    path = robot_path(name_or_path) if known else Path(name_or_path)
    findings = check_urdf(path)
    raise_errors(path, findings)
    robot = get_robot(path)
    server = ViewerServer(host, port)
    try:
        RobotView(robot, findings, server)
        say(f"Showing {robot.name} at {server.url}")
        keep_open(server, say, browse=browse)
    finally:
        server.stop()


def play(
    name_or_path: str,
    host: str,
    port: int | None,
    say: Say,
    *,
    browse: bool,
    physics: Physics | None = None,
    reference_only: bool = False,
) -> None:
    """Let the hands of a robot be dragged until Ctrl-C; `physics` None: mujoco where there is one.

    Raises: `RobotFileError`, `InputError` for a robot of which nothing can be dragged.
    """
    robot = get_robot(name_or_path)
    session = (
        ReferenceSession(robot)
        if reference_only
        else WalkingSession(robot, physics or usual_physics())
    )
    server = ViewerServer(host, port)
    try:
        shown = Play(session, server)
        shown.start()
        walks = isinstance(session, WalkingSession) and session.fastest is not None
        also = ", or let it walk," if walks else ""
        say(f"Drag the hands of {robot.name}{also} at {server.url}")
        keep_open(server, say, browse=browse)
        shown.stop()
    finally:
        server.stop()


class Watch:
    """Shows a run while it goes on: give `steer` to `run_scenario`, then call `finish`."""

    def __init__(self, host: str, port: int | None, say: Say) -> None:
        self._host, self._port, self._say = host, port, say
        self._bridge: Bridge | None = None

    def steer(self, simulation: ControlledRun, folder: Path) -> Bridge:
        """Open the page and wait until somebody looks."""
        self._bridge = Bridge(simulation, self._host, self._port)
        self._say(f"The run can be watched at {self._bridge.url}")
        if _has_screen():
            webbrowser.open(self._bridge.url)
        self._bridge.wait_for_page(self._say)
        return self._bridge

    def finish(self, folder: Path) -> None:
        """Show the finished run on the same page until Ctrl-C, then close it."""
        if self._bridge is None:
            return
        self._bridge.finish(folder)
        _wait(
            self._say,
            f"The page now shows the finished run: {self._bridge.url}  Ctrl-C ends it.",
        )
        self._bridge.close()


def keep_open(server: ViewerServer, say: Say, *, browse: bool) -> None:
    """Open a browser where there is a screen, then wait for Ctrl-C."""
    if server.guard.opened:
        say("Open to the network: whoever has this address with its token can look and push.")
    if browse and _has_screen():
        webbrowser.open(server.url)
    _wait(say, "Ctrl-C ends it.")


def _wait(say: Say, what: str) -> None:
    """Say that Ctrl-C is waited for, and do so: who reads it may press it at once."""
    with suppress(KeyboardInterrupt):
        say(what)
        never = threading.Event()
        while not never.wait(1.0):  # looks up now and then: a signal may come to another thread
            pass


def _has_screen() -> bool:
    if sys.platform == "darwin" or os.name == "nt":
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
