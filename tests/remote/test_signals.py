"""Ctrl-C, SIGTERM and kill of two programs: the robot ends standing, the session is kept."""

from __future__ import annotations

import os
import re
import signal
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from two_programs import compile_kernels, program, udp_robot

import equipoise
from equipoise.errors import InputError
from equipoise.remote.drive import RemoteRun
from equipoise.remote.options import WireOptions
from equipoise.remote.signals import StopSignals
from equipoise.scenarios import read_scenario
from equipoise.wire import RobotLostError
from equipoise.wire.session import SessionRobot
from equipoise.wire.session_file import read_session

SCENARIO = ["press", "--set", "duration=8"]
DRIVE = ["control", *SCENARIO, "--arm", "--no-figures", "--out", "far", "--record", "said"]
LONGEST = 240.0  # [s] that programs are waited for
INTERRUPTED, NOT_PASSED = 130, 1


@pytest.fixture(scope="module", autouse=True)
def compiled(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Have all kernels compiled, or a program takes minutes to begin."""
    compile_kernels(tmp_path_factory.mktemp("compiled"))


def last_time(session: Path) -> float:
    """Return the time [s] that a session has come to, -1 if nobody has spoken yet."""
    try:
        return float(read_session(session).chunks[-1].states["t"][-1])
    except (InputError, IndexError):
        return -1.0


def wait_until(true: Callable[[], bool]) -> None:
    until = time.monotonic() + LONGEST
    while not true():
        assert time.monotonic() < until
        time.sleep(0.05)


def require_standing(said: str) -> None:
    """Refuse a robot that did not end standing and slow, by its own report."""
    assert "It held itself" in said
    lowered, base, joint = (
        float(re.search(pattern, said).group(1))
        for pattern in (r"down by (-?\d+) mm", r"moved at ([\d.]+) m/s", r"joint at ([\d.]+) rad")
    )
    assert abs(lowered) <= 5.0
    assert base <= 0.1
    assert joint <= 0.5


def test_a_controller_that_is_killed_has_written_what_was_said(tmp_path: Path):
    """Its robot waits in lockstep; Ctrl-C there lets it hold itself."""
    with udp_robot(tmp_path, *SCENARIO) as (robot, port):
        with program(tmp_path, *DRIVE, "--wire-port", port) as loop:
            wait_until(lambda: last_time(tmp_path / "said") > 0.5)
            loop.send_signal(signal.SIGKILL)
            loop.wait(LONGEST)
        robot.send_signal(signal.SIGINT)
        told, _ = robot.communicate(timeout=LONGEST)
    assert robot.returncode == INTERRUPTED
    assert "on its own: Ctrl-C" in told
    require_standing(told)
    run = RemoteRun(
        read_scenario("press", ["duration=8"]),
        WireOptions(f"session:{tmp_path / 'said'}").connect,
        lockstep=True,
    )
    assert isinstance(run.link, SessionRobot)
    assert "was not closed" in run.link.damage
    ticks = run.ticks()
    with pytest.raises(RobotLostError, match="session is over"):
        for _ in ticks:
            pass
    assert run.link.compared > 500
    assert run.link.apart < 1e-8  # [N m]; 0 unless this process has compiled the kernels itself
    kept = equipoise.load_run(tmp_path / "far")
    assert kept.t[-1] > 0.4


@pytest.mark.parametrize("pace", ["--lockstep", pytest.param("--realtime", marks=pytest.mark.slow)])
def test_ctrl_c_at_the_controller_ramps_out(tmp_path: Path, pace):
    with udp_robot(tmp_path, *SCENARIO, pace) as (robot, port):
        with program(tmp_path, *DRIVE, "--wire-port", port, pace) as loop:
            wait_until(lambda: last_time(tmp_path / "said") > 0.5)
            loop.send_signal(signal.SIGINT)
            said, _ = loop.communicate(timeout=LONGEST)
        told, _ = robot.communicate(timeout=LONGEST)
    assert loop.returncode == INTERRUPTED, said
    assert robot.returncode == 0, told
    assert "the commander said so" in told
    require_standing(told)
    run = equipoise.load_run(tmp_path / "far")
    assert run.summary["ended"] == "interrupted"
    assert any("ramped out: Ctrl-C" in one for one in run.summary["changes"])
    assert read_session(tmp_path / "said").damage == ""


def test_ctrl_c_at_the_robot_is_told_to_the_controller(tmp_path: Path):
    with (
        udp_robot(tmp_path, *SCENARIO) as (robot, port),
        program(tmp_path, *DRIVE, "--wire-port", port) as loop,
    ):
        wait_until(lambda: last_time(tmp_path / "said") > 0.5)
        robot.send_signal(signal.SIGINT)
        told, _ = robot.communicate(timeout=LONGEST)
        said, _ = loop.communicate(timeout=LONGEST)
    assert robot.returncode == INTERRUPTED
    require_standing(told)
    assert loop.returncode == NOT_PASSED, said
    run = equipoise.load_run(tmp_path / "far")
    assert run.summary["ended"] == "lost"
    assert "holds itself" in run.summary["note"]
    assert read_session(tmp_path / "said").damage == ""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_first_signal_asks_and_the_second_interrupts(number):
    before, signals = signal.getsignal(number), StopSignals()
    signals.take()
    try:
        assert signals.asked() == ""
        os.kill(os.getpid(), number)
        assert signals.asked() in ("Ctrl-C", "SIGTERM")
        with pytest.raises(KeyboardInterrupt):
            os.kill(os.getpid(), number)
    finally:
        signals.give_back()
    assert signal.getsignal(number) is before


def test_a_signal_interrupts_who_does_not_look_yet():
    signals = StopSignals()
    signals.take()
    try:
        with pytest.raises(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGTERM)
    finally:
        signals.give_back()
