"""Keeping a period: absolute deadlines, and what the operating system permits for them."""

from __future__ import annotations

import ctypes
import os
import time
from dataclasses import dataclass, field

import numpy as np

from equipoise.spatial import Array
from equipoise.spatial.numbers import require_period

PRIORITY = 20  # of SCHED_FIFO: above what is ordinary, below the kernel's own threads
MCL_CURRENT, MCL_FUTURE = 1, 2  # of mlockall(2)
FAR_BEHIND = 50  # periods after which the past is given up
EDGES_US = (50, 100, 200, 500, 1000, 2000, 5000, 10000)


@dataclass
class Lateness:
    """How late ticks began: their number by class, the worst [s], how often time was given up."""

    counts: Array = field(default_factory=lambda: np.zeros(len(EDGES_US) + 1, dtype=int))
    worst: float = 0.0
    given_up: int = 0

    def note(self, late: float) -> None:
        """Note a tick that began `late` [s]."""
        self.counts[int(np.searchsorted(EDGES_US, 1e6 * late))] += 1
        self.worst = max(self.worst, late)

    def sentence(self, period: float) -> str:
        """Return in words how well a period [s] was kept."""
        classes = zip(EDGES_US, self.counts, strict=False)
        said = [f"{n} up to {edge} us" for edge, n in classes if n]
        said += [f"{self.counts[-1]} beyond"] if self.counts[-1] else []
        gave_up = f"; time was given up {self.given_up} times" if self.given_up else ""
        return (
            f"{int(self.counts.sum())} ticks of {1e3 * period:g} ms, late by: {', '.join(said)}; "
            f"at worst {1e3 * self.worst:.2f} ms{gave_up}"
        )


class Ticker:
    """Wakes up once a period, at times that do not drift."""

    def __init__(self, period: float) -> None:
        self.period, self.lateness = require_period(period), Lateness()
        self._next = time.monotonic()

    def wait(self) -> None:
        """Return at the next time; at once if it is over, and note how late that is.

        Far behind, the times are counted anew from now.
        """
        self._next += self.period
        left = self._next - time.monotonic()
        if left > 0.0:
            time.sleep(left)
        late = time.monotonic() - self._next
        self.lateness.note(max(late, 0.0))
        if late > FAR_BEHIND * self.period:
            self.lateness.given_up += 1
            self._next = time.monotonic()


def claim_machine(*, lock: bool = True) -> list[str]:
    """Ask for SCHED_FIFO and, to `lock`, memory that stays; return in words what was permitted.

    All threads of this program get it, those that receive messages too; programs that it starts do
    not.
    """
    told = []
    try:
        for thread in os.listdir("/proc/self/task"):
            policy = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
            os.sched_setscheduler(int(thread), policy, os.sched_param(PRIORITY))
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


def _why(error: Exception) -> str:
    strerror = getattr(error, "strerror", None)
    return str(strerror or error).lower()
