"""Whether memory grows: ticks of the hard case and the law, counted in blocks and pages."""

from __future__ import annotations

import gc
import resource
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from equipoise.bench.interleave import Progress
from equipoise.bench.problem import HANDS, Problem
from equipoise.bench.unreachable_targets import throw_hands

BLOCKS_MAX = 500  # Python objects more at the end than in the middle
PAGES_MAX = 1_000_000  # bytes more at the end than in the middle


@dataclass(frozen=True)
class Growth:
    """What the second half of `ticks` ticks added: Python's `blocks`, and `resident` [bytes]."""

    ticks: int
    blocks: int
    resident: int

    @property
    def passed(self) -> bool:
        """Whether nothing is kept from tick to tick: at most 500 objects and 1 MB in all."""
        return self.blocks <= BLOCKS_MAX and self.resident <= PAGES_MAX

    def __str__(self) -> str:
        verdict = "does not grow" if self.passed else "GROWS"
        return (
            f"{self.ticks} ticks; the second half added {self.blocks} objects "
            f"and {self.resident / 1e6:.2f} MB: memory {verdict}"
        )


def measure_memory(problem: Problem, ticks: int, report: Progress | None = None) -> Growth:
    """Run motion (hands thrown out of reach every ten ticks) and law; compare halves.

    The law is told that the robot does what the reference says; no engine runs.
    """
    controller = problem.make_controller(throw_hands(problem, HANDS))
    lam = np.zeros(problem.simulation.setup.contacts.size)
    q, v, middle = problem.q_start, np.zeros(problem.robot.nv), (0, 0)
    for k in range(ticks):
        t = k * problem.dt
        command = controller.step(t, q, v, lam[: problem.simulation.setup.schedule.at(t).size])
        q, v = command.q_ref, command.v_ref
        if k == ticks // 2:
            middle = _now()
        if report is not None and k % 1000 == 0:
            report("ticks", k / ticks)
    blocks, resident = _now()
    return Growth(ticks, blocks - middle[0], resident - middle[1])


def _now() -> tuple[int, int]:
    gc.collect()
    return sys.getallocatedblocks(), _resident()


def _resident() -> int:
    """Return the memory [bytes] that is in use, or where that is not told, its peak."""
    statm = Path("/proc/self/statm")
    if statm.exists():
        return int(statm.read_text().split()[1]) * resource.getpagesize()
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else 1024 * peak
