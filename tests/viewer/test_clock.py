"""The clock of a replay."""

from __future__ import annotations

import time

import pytest

pytest.importorskip("viser", reason="needs the extra 'viewer': pip install -e '.[viewer]'")

from equipoise.viewer.clock import Clock


def test_time_passes_with_the_speed_and_stands_at_the_end() -> None:
    clock = Clock(1.0, 3.0)
    clock.advance(0.5)
    assert clock.t == 1.0
    clock.play(True)
    clock.set_speed(2.0)
    clock.advance(0.5)
    assert clock.t == 2.0
    clock.advance(10.0)
    assert (clock.t, clock.playing) == (3.0, False)


def test_playing_at_the_end_begins_anew() -> None:
    clock = Clock(1.0, 3.0)
    clock.seek(7.0)
    assert clock.t == 3.0
    clock.play(True)
    assert clock.t == 1.0


def test_a_request_wakes_the_sleeper() -> None:
    clock = Clock(0.0, 1.0)
    clock.seek(0.5)
    began = time.perf_counter()
    clock.wait(300.0)
    assert time.perf_counter() - began < 200.0
