"""When the loop ticks, with a robot and a clock that are told what to do."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from equipoise.remote import realtime
from equipoise.remote.pace import LOST, PATIENCE, SLACK, Due, Lockstep, RealTime
from equipoise.remote.realtime import CATCH_UP, EDGES_US, Lateness, Ticker
from equipoise.wire import CommandMode, RobotCommand, RobotLostError, RobotMode, RobotState

DT = 1e-3
ANSWER = RobotCommand(0.0, CommandMode.TORQUE, np.zeros(1))


def state(tick: int, mode: RobotMode = RobotMode.DRIVEN) -> RobotState:
    nothing = np.zeros(1)
    return RobotState(1, tick * DT, mode, np.zeros(4), nothing, nothing, nothing, nothing)


class Told:
    """A robot whose states arrive at given times [s], and a clock that goes on by waiting."""

    def __init__(self, *arrivals: tuple[float, RobotState]) -> None:
        self.now, self.arrivals, self.written = 0.0, list(arrivals), 0

    def read(self, timeout: float) -> RobotState | None:
        until = self.now + timeout
        if not self.arrivals or self.arrivals[0][0] > until:
            self.now = until
            return None
        at, newest = self.arrivals.pop(0)
        self.now = max(self.now, at)
        return newest

    def write(self, command: RobotCommand) -> None:
        self.written += 1

    def close(self) -> None:
        pass


def tick_on(pace: RealTime) -> None:
    tick = 0
    while True:
        tick = pace.next(tick, ANSWER).tick


def real_time(*arrivals: tuple[float, RobotState]) -> tuple[Told, RealTime]:
    robot = Told(*arrivals)
    return robot, RealTime(robot, DT, lambda: robot.now)


def test_lockstep_answers_again_until_the_next_state_comes():
    robot = Told((0.01, state(4)), (0.05, state(5)))
    due = Lockstep(robot, DT, lambda: robot.now).next(4, ANSWER)
    assert due.tick == 5
    assert robot.written == 2  # to the copy, and to the silence after it


def test_lockstep_gives_up_in_the_end():
    robot = Told()
    with pytest.raises(RobotLostError, match="has said nothing"):
        Lockstep(robot, DT, lambda: robot.now).next(0, ANSWER)
    assert robot.now >= PATIENCE


def test_a_tick_is_due_when_its_state_comes():
    robot, pace = real_time((DT, state(1)))
    assert pace.next(0, ANSWER).tick == 1
    assert robot.now == DT


def test_a_tick_without_a_state_is_due_a_little_later_and_the_next_a_period_after():
    robot, pace = real_time((DT, state(1)))
    pace.next(0, ANSWER)
    assert pace.next(1, ANSWER) == Due(2, None)
    assert robot.now == pytest.approx(2 * DT + SLACK)
    assert pace.next(2, ANSWER) == Due(3, None)
    assert robot.now == pytest.approx(3 * DT + SLACK)
    assert pace.missed == 2


def test_what_was_skipped_is_counted_and_not_waited_for():
    _, pace = real_time((DT, state(1)), (4 * DT, state(4)))
    pace.next(0, ANSWER)
    assert pace.next(1, ANSWER).tick == 4
    assert pace.skipped == 2


def test_a_late_state_is_given_to_the_next_tick():
    late = state(2)
    _, pace = real_time((DT, state(1)), (2 * DT + SLACK + 0.5 * DT, late))
    pace.next(0, ANSWER)
    assert pace.next(1, ANSWER).state is None
    assert pace.next(2, ANSWER) == Due(3, late)


def test_a_robot_whose_time_stood_still_is_waited_for():
    """Every state comes 10 periods later from the sixth on: after a while none is late any more."""
    arrivals = [((k + 10 * (k > 5)) * DT, state(k)) for k in range(1, 200)]
    _, pace = real_time(*arrivals)
    tick, without = 0, []
    while tick < 199:
        before = pace.missed
        tick, _ = pace.next(tick, ANSWER)
        without.append(pace.missed - before)
    assert sum(without) <= 25
    assert sum(without[-150:]) == 0


def test_a_delay_that_stays_is_no_lateness():
    """Times are those of the arrivals: a wire of constant length loses nothing."""
    _, pace = real_time(*((k * DT + 0.02, state(k)) for k in range(1, 50)))
    tick, without = 0, 0
    while tick < 49:
        tick, given = pace.next(tick, ANSWER)
        without += given is None
    assert without == pace.missed == 0


def test_a_robot_that_says_nothing_is_lost():
    robot, pace = real_time((DT, state(1)))
    with pytest.raises(RobotLostError):
        tick_on(pace)
    assert robot.now == pytest.approx(LOST, abs=0.01)


def test_a_robot_that_never_answers_is_lost():
    robot, pace = real_time()
    with pytest.raises(RobotLostError):
        pace.next(0, ANSWER)
    assert robot.now == pytest.approx(LOST, abs=0.05)


def test_the_first_answer_is_given_until_it_is_heard():
    robot, pace = real_time((0.03, state(0, RobotMode.WAITING)), (0.06, state(1)))
    assert pace.next(0, ANSWER).tick == 1
    assert robot.written == 3
    assert pace.skipped == 0


@pytest.mark.parametrize("mode", [RobotMode.HELD, RobotMode.SUNK, RobotMode.ENDED])
def test_a_robot_that_has_let_go_is_not_driven_on(mode):
    _, pace = real_time((DT, state(1, mode)))
    with pytest.raises(RobotLostError, match="holds itself"):
        pace.next(0, ANSWER)


def test_deadlines_do_not_drift(monkeypatch):
    """However long a tick takes, the n-th begins at n periods or right after the one before."""
    clock = [100.0]
    monkeypatch.setattr(realtime.time, "monotonic", lambda: clock[0])
    monkeypatch.setattr(realtime.time, "sleep", lambda s: clock.__setitem__(0, clock[0] + s))
    ticker, random = Ticker(DT, catch_up=1.0), np.random.default_rng(0)
    for _ in range(1000):
        ticker.wait()
        clock[0] += random.uniform(0.0, 1.9 * DT) * (random.random() < 0.8)
    ticker.wait()
    assert clock[0] == pytest.approx(100.0 + 1001 * DT, abs=3 * DT)
    assert ticker.lateness.counts.sum() == 1001
    assert ticker.lateness.given_up == 0


def test_a_long_stop_is_not_caught_up_with(monkeypatch):
    clock = [0.0]
    monkeypatch.setattr(realtime.time, "monotonic", lambda: clock[0])
    monkeypatch.setattr(realtime.time, "sleep", lambda s: clock.__setitem__(0, clock[0] + s))
    ticker = Ticker(DT)
    clock[0] = 1.0
    ticker.wait()
    assert ticker.lateness.given_up == 1
    ticker.wait()
    assert clock[0] == pytest.approx(1.0 + DT)


def test_a_robot_that_was_late_does_not_go_far_at_once(monkeypatch):
    """Whatever a tick took, no more than `catch_up` is made good without waiting."""
    clock, starts = [0.0], []
    monkeypatch.setattr(realtime.time, "monotonic", lambda: clock[0])
    monkeypatch.setattr(realtime.time, "sleep", lambda s: clock.__setitem__(0, clock[0] + s))
    ticker, random = Ticker(DT), np.random.default_rng(1)
    for _ in range(2000):
        ticker.wait()
        starts.append(clock[0])
        clock[0] += random.choice([0.0002, 0.004, 0.03], p=[0.98, 0.01, 0.01])
    ahead = round(CATCH_UP / DT) + 2  # ticks that may begin within one period
    for k in range(len(starts) - ahead):
        assert starts[k + ahead] - starts[k] > DT
    given_up = clock[0] - 2000 * DT
    assert ticker.lateness.given_up_s == pytest.approx(given_up, abs=CATCH_UP + 0.03)


def test_lateness_is_told_by_class():
    lateness = Lateness()
    for late in (10e-6, 60e-6, 60e-6, 0.5):
        lateness.note(late)
    assert lateness.counts.tolist() == [1, 2, *([0] * (len(EDGES_US) - 2)), 1]
    said = lateness.sentence(DT)
    assert "4 ticks of 1 ms" in said
    assert "1 up to 50 us, 2 up to 100 us, 1 beyond" in said
    assert "at worst 500.00 ms" in said


def test_claiming_the_machine_says_what_was_permitted():
    """In a program of its own, whose children are scheduled as usual."""
    code = (
        "import os, subprocess, sys; "
        "from equipoise.remote.realtime import claim_machine, release_machine; "
        "print(claim_machine(lock=False)); sys.stdout.flush(); "
        "release_machine(); print(os.sched_getscheduler(0)); sys.stdout.flush(); claim_machine(); "
        "subprocess.run([sys.executable, '-c', 'import os; print(os.sched_getscheduler(0))'])"
    )
    said = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout.splitlines()
    assert "scheduled" in said[0]
    assert said[1:] == ["0", "0"]  # SCHED_OTHER: after it was given back, and of a child
