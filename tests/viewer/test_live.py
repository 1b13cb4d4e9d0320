"""The live viewer: the process that draws, what its panel asks for, and losing it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from steered_runs import simulation
from viewer_logs import tray_places

pytest.importorskip("viser", reason="needs the extra 'viewer': pip install -e '.[viewer]'")

import viser
from websockets.sync.client import connect

from equipoise.runlog import load_run
from equipoise.scenarios import read_scenario
from equipoise.simulation.loop import Ending, run_simulation
from equipoise.simulation.operator import OperatorRequest
from equipoise.viewer.base_link import base_link
from equipoise.viewer.bridge import Bridge
from equipoise.viewer.operator_panel import OperatorPanel
from equipoise.viewer.server import ViewerServer


def test_the_panel_asks_only_for_what_was_changed(server: ViewerServer) -> None:
    sent: list[tuple[str, object]] = []
    panel = OperatorPanel(
        server.viser.gui,
        read_scenario("tray"),
        tray_places(),
        "BODY",
        lambda kind, content: sent.append((kind, content)),
    )
    assert panel.request == OperatorRequest()
    panel._push[0].value = 30.0
    panel._gains["alpha"].value = 12.5
    panel._forces["grasp/fz"].value = 5.0
    assert sent == []  # only a person's hand sends
    panel._changed(SimpleNamespace(client_id=1))
    wanted = OperatorRequest(
        push=(30.0, 0.0, 0.0),
        push_frame="BODY",
        gains={"alpha": 12.5},
        forces={"grasp/fz": 5.0},
    )
    assert sent == [("request", wanted)]
    panel._release()
    assert sent[-1][1].push == (0.0, 0.0, 0.0)
    panel.step(3)
    panel.toggle()
    assert sent[-2:] == [("step", 3), ("run", True)]


def test_the_run_goes_on_under_what_stands_in_the_controls(server: ViewerServer) -> None:
    """Also where the thread that tells of a new value comes too late."""
    sent: list[tuple[str, object]] = []
    panel = OperatorPanel(
        server.viser.gui,
        read_scenario("tray"),
        tray_places(),
        "BODY",
        lambda kind, content: sent.append((kind, content)),
    )
    panel._gains["alpha"].value = 7.5
    panel.toggle()
    panel.toggle()
    panel._changed(SimpleNamespace(client_id=1))
    wanted = OperatorRequest(gains={"alpha": 7.5})
    assert sent == [("request", wanted), ("run", False), ("run", True)]


def test_what_was_typed_last_is_sent_last(server: ViewerServer) -> None:
    sent: list[float] = []
    first_is_on_its_way, go_on = threading.Event(), threading.Event()

    def send(_kind: str, request: OperatorRequest) -> None:
        if not first_is_on_its_way.is_set():
            first_is_on_its_way.set()
            go_on.wait(10.0)
        sent.append(request.gains["alpha"])

    panel = OperatorPanel(server.viser.gui, read_scenario("tray"), tray_places(), "BODY", send)
    hand = SimpleNamespace(client_id=1)
    threads = [threading.Thread(target=panel._changed, args=(hand,)) for _ in range(2)]
    panel._gains["alpha"].value = 7.0
    threads[0].start()
    assert first_is_on_its_way.wait(10.0)
    panel._gains["alpha"].value = 7.5
    threads[1].start()
    threads[1].join(0.2)  # it would overtake here
    go_on.set()
    for thread in threads:
        thread.join(10.0)
    assert sent == [7.0, 7.5]


def test_the_button_says_what_the_run_was_told_last(server: ViewerServer) -> None:
    sent: list[tuple[str, object]] = []
    first_is_on_its_way, go_on = threading.Event(), threading.Event()

    def send(kind: str, content: object) -> None:
        if kind == "step":
            first_is_on_its_way.set()
            go_on.wait(10.0)
        sent.append((kind, content))

    panel = OperatorPanel(server.viser.gui, read_scenario("tray"), tray_places(), "BODY", send)
    threads = [threading.Thread(target=action) for action in (lambda: panel.step(1), panel.toggle)]
    threads[0].start()
    assert first_is_on_its_way.wait(10.0)
    threads[1].start()
    threads[1].join(0.2)  # it would overtake here
    go_on.set()
    for thread in threads:
        thread.join(10.0)
    assert sent == [("step", 1), ("run", True)]
    assert panel._pause.label == "Pause"  # the run goes on


def until(happened: Callable[[], object]) -> None:
    deadline = time.perf_counter() + 180.0
    while not happened():
        assert time.perf_counter() < deadline, "it did not happen"
        time.sleep(0.01)


@pytest.fixture(scope="module")
def watched(tmp_path_factory: pytest.TempPathFactory):
    """A run that was watched by one page through a real process, which was then killed."""
    folder = tmp_path_factory.mktemp("watched") / "run"
    made = simulation(0.25)
    bridge = Bridge(made, "127.0.0.1", 0)
    received = []
    page = connect(
        bridge.url.replace("http", "ws"),
        origin=bridge.url.rstrip("/"),
        subprotocols=[f"viser-v{viser.__version__}"],
        max_size=None,
    )

    def listen() -> None:
        try:
            while True:
                received.append(len(page.recv()))
        except Exception:
            return

    thread = threading.Thread(target=listen, daemon=True)
    thread.start()
    made.operate(bridge)
    bridge._wanted = 2  # as if the page had reported its camera
    seen: list[int] = []

    def progress(t: float) -> None:
        if len(seen) == 2:  # the page gets its time, however slow it is
            until(lambda: len(received) > before)
        seen.append(len(received))
        if len(seen) == 3:
            bridge.process.kill()
            bridge.process.join()

    until(lambda: received)
    time.sleep(0.5)
    before = len(received)
    outcome = run_simulation(made, folder, progress)
    page.close()
    thread.join(timeout=60.0)
    return SimpleNamespace(
        outcome=outcome, run=load_run(folder), before=before, during=seen[2], bridge=bridge
    )


def test_the_page_is_fed_while_the_run_goes_on(watched) -> None:
    assert watched.before > 0  # the scene
    assert watched.during > watched.before  # and then what moves


def test_a_lost_page_lets_the_run_go_on(watched) -> None:
    assert watched.outcome.ending is Ending.COMPLETED
    assert len(watched.run.t) == 250
    assert not watched.bridge._connected


def test_pause_step_and_stop_reach_the_loop() -> None:
    made = simulation(0.02)
    bridge = Bridge(made, "127.0.0.1", 0)
    try:
        made.operate(bridge)
        for message in (
            ("step", 3),
            ("request", OperatorRequest(push=(1.0, 0.0, 0.0), push_frame="BODY")),
        ):
            bridge._take(*message)
        ticks = made.ticks()
        times = [next(ticks)[0] for _ in range(3)]
        assert np.allclose(times, [0.0, 0.001, 0.002])
        waiting = threading.Thread(target=lambda: times.append(next(ticks)[0]), daemon=True)
        waiting.start()
        time.sleep(0.3)
        assert len(times) == 3  # it stands
        bridge._take("run", True)
        waiting.join(timeout=60.0)
        assert len(times) == 4
        assert bridge.paused_s > 0.0
        assert made.operator_port is not None
        assert made.operator_port.request.push == (1.0, 0.0, 0.0)
    finally:
        bridge.close()
    assert not bridge.process.is_alive()


def test_the_base_link_is_a_link() -> None:
    robot = tray_places().robot
    assert robot.model.frames[robot.frame_id(base_link(robot))].parentJoint == 1


def test_the_port_that_is_taken_is_said_before_the_run(server: ViewerServer) -> None:
    from equipoise.errors import EquipoiseError

    with pytest.raises(EquipoiseError, match=f"port {server.port}"):
        Bridge(simulation(0.01), "127.0.0.1", server.port)


def test_folder_is_not_touched_by_the_page(watched, tmp_path: Path) -> None:
    names = sorted(path.name for path in watched.run.folder.iterdir())
    assert names == ["run.mcap", "scenario.yaml"]
