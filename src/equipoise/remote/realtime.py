"""Keeping a period: absolute deadlines, and what the operating system permits for them."""

from __future__ import annotations

import ctypes
import os
import sys
import time
from contextlib import suppress
from dataclasses import dataclass, field

import numpy as np

from equipoise.spatial import Array
from equipoise.spatial.numbers import require_period

PRIORITY = 20  # of SCHED_FIFO: above what is ordinary, below the kernel's own threads
MCL_CURRENT, MCL_FUTURE = 1, 2  # of mlockall(2)
CATCH_UP = 0.005  # [s] that are made good at once; what is later than that is given up
GIVE_WAY = 5e-4  # [s] after which a thread of Python lets another one go on
USUAL_GIVE_WAY = sys.getswitchinterval()
EDGES_US = (50, 100, 200, 500, 1000, 2000, 5000, 10000)


@dataclass
class Lateness:
    """How late ticks began: their number by class, the worst [s], what was given up [s]."""

    counts: Array = field(default_factory=lambda: np.zeros(len(EDGES_US) + 1, dtype=int))
    worst: float = 0.0
    given_up: int = 0
    given_up_s: float = 0.0

    def note(self, late: float) -> None:
        """Note a tick that began `late` [s]."""
        self.counts[int(np.searchsorted(EDGES_US, 1e6 * late))] += 1
        self.worst = max(self.worst, late)

    def sentence(self, period: float) -> str:
        """Return in words how well a period [s] was kept."""
        classes = zip(EDGES_US, self.counts, strict=False)
        said = [f"{n} up to {edge} us" for edge, n in classes if n]
        said += [f"{self.counts[-1]} beyond"] if self.counts[-1] else []
        gave_up = ""
        if self.given_up:
            gave_up = f"; {1e3 * self.given_up_s:.0f} ms were given up, {self.given_up} times"
        return (
            f"{int(self.counts.sum())} ticks of {1e3 * period:g} ms, late by: {', '.join(said)}; "
            f"at worst {1e3 * self.worst:.2f} ms{gave_up}"
        )


class Ticker:
    """Wakes up once a period, at times that do not drift.

    What is late by more than `catch_up` [s] is given up: a robot that went through all of it at
    once would go far without a command.
    """

    def __init__(self, period: float, catch_up: float = CATCH_UP) -> None:
        self.period, self.lateness = require_period(period), Lateness()
        self.catch_up = catch_up
        self._next = time.monotonic()

    def wait(self) -> None:
        """Return at the next time; at once if it is over, and note how late that is."""
        self._next += self.period
        left = self._next - time.monotonic()
        if left > 0.0:
            time.sleep(left)
        late = time.monotonic() - self._next
        self.lateness.note(max(late, 0.0))
        if late > self.catch_up:
            self.lateness.given_up += 1
            self.lateness.given_up_s += late
            self._next += late


def claim_machine(*, lock: bool = True) -> list[str]:
    """Ask for SCHED_FIFO and, to `lock`, memory that stays; return in words what was permitted.

    All threads of this program get it, those that receive messages too; programs that it starts do
    not. Threads of Python wait for each other for half a millisecond at most.
    """
    told = []
    sys.setswitchinterval(GIVE_WAY)
    try:
        _schedule(os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, PRIORITY)
        told.append(f"scheduled first in, first out, with priority {PRIORITY}")
    except (AttributeError, OSError) as error:
        told.append(f"scheduled like any other program ({_why(error)})")
    if not lock:
        return told
    try:
        libc = ctypes.CDLL(None, use_errno=True)
        if libc.mlockall(MCL_CURRENT | MCL_FUTURE):
            raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
        told.append("memory is locked")
    except (AttributeError, OSError) as error:
        told.append(f"memory may be paged out ({_why(error)})")
    return told


def release_machine() -> None:
    """Be a program like any other again."""
    sys.setswitchinterval(USUAL_GIVE_WAY)
    with suppress(AttributeError, OSError):
        _schedule(os.SCHED_OTHER, 0)
        ctypes.CDLL(None).munlockall()


def _schedule(policy: int, priority: int) -> None:
    """Schedule all threads of this program so. Raises: `OSError` where that is not permitted."""
    for thread in os.listdir("/proc/self/task"):
        with suppress(ProcessLookupError):  # it has ended since
            os.sched_setscheduler(int(thread), policy, os.sched_param(priority))


def _why(error: Exception) -> str:
    strerror = getattr(error, "strerror", None)
    return str(strerror or error).lower()
