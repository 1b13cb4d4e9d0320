"""`equipoise control --view`: the run is shown while it goes on, and goes on without its viewer."""

from __future__ import annotations

import os
import signal
import threading
import time
from pathlib import Path

import pytest
from two_programs import compile_kernels, program, udp_robot

pytest.importorskip("viser", reason="needs the extra 'viewer': pip install -e '.[viewer]'")

import viser
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

import equipoise

SCENARIO = ["press", "--set", "duration=1.5"]
VIEW = ["--arm", "--no-figures", "--out", "far", "--view", "--port", "0"]
LONGEST = 240.0  # [s] that programs are waited for


class Page:
    """What a page gets, listened to in a thread."""

    def __init__(self, url: str) -> None:
        self.received = 0
        self._link: ClientConnection = connect(
            url.replace("http", "ws"),
            origin=url.rstrip("/"),
            subprotocols=[f"viser-v{viser.__version__}"],
            max_size=None,
        )
        self.thread = threading.Thread(target=self._listen, daemon=True)
        self.thread.start()

    def _listen(self) -> None:
        try:
            while True:
                self.received += len(self._link.recv()) > 0
        except ConnectionClosed:
            return


def children_of(pid: int) -> list[int]:
    """Return the programs that a program has started."""
    return [int(one) for one in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def test_a_run_that_is_watched_goes_on_when_its_viewer_crashes(tmp_path: Path):
    compile_kernels(tmp_path)
    with (
        udp_robot(tmp_path, *SCENARIO) as (robot, port),
        program(tmp_path, "control", *SCENARIO, *VIEW, "--wire-port", port) as loop,
    ):
        line = next(one for one in loop.stdout if "can be watched at" in one)
        viewers = children_of(loop.pid)
        page = Page(line.split("watched at ")[1].strip())
        until = time.monotonic() + LONGEST
        while not page.received:  # the scene is shown
            assert time.monotonic() < until
            time.sleep(0.05)
        assert viewers
        for viewer in viewers:
            os.kill(viewer, signal.SIGKILL)
        said = ""
        for line in loop.stdout:
            said += line
            if "shows the finished run" in line:
                break
        loop.send_signal(signal.SIGINT)
        loop.communicate(timeout=LONGEST)
        told, _ = robot.communicate(timeout=LONGEST)
    assert "It held itself" in told
    run = equipoise.load_run(tmp_path / "far")
    assert run.t.size == 1500, said
    assert run.summary["ended"] == "completed"
