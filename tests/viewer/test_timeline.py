"""The time line under quick hands: nothing that a person asked for is lost between threads."""

from __future__ import annotations

import threading
import time
from types import SimpleNamespace

import pytest

pytest.importorskip("viser", reason="needs the extra 'viewer': pip install -e '.[viewer]'")

from equipoise.viewer.clock import Clock
from equipoise.viewer.server import ViewerServer
from equipoise.viewer.timeline import TimeLine

TICK = 0.001
HAND = SimpleNamespace(client_id=1)


def slow_after(t: float) -> float:
    """Return the next tick, after a while, as a long log does."""
    time.sleep(0.05)
    return t + TICK


def test_what_was_just_typed_is_not_overwritten_by_the_picture(server: ViewerServer) -> None:
    clock = Clock(0.0, 1.0)
    line = TimeLine(server.viser.gui, clock, slow_after, slow_after)
    line.show()
    line._slider.value = 0.25  # as the page has sent it
    line.show()  # the thread that draws is faster than the one that obeys
    line._slid(HAND)
    assert clock.t == 0.25
    clock.seek(0.5)
    line.show()
    assert line._slider.value == 0.5


def test_two_quick_steps_are_two(server: ViewerServer) -> None:
    clock = Clock(0.0, 1.0)
    line = TimeLine(server.viser.gui, clock, slow_after, slow_after)
    threads = [threading.Thread(target=line.step, args=(1,)) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(10.0)
    assert clock.t == pytest.approx(3.0 * TICK)


def test_two_presses_of_play_cancel_out() -> None:
    clock = Clock(0.0, 1.0)
    threads = [threading.Thread(target=clock.toggle) for _ in range(50)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(10.0)
    assert not clock.playing
    clock.seek(1.0)
    clock.toggle()
    assert (clock.t, clock.playing) == (0.0, True)  # at the end it begins anew
