"""Runs contenders in turns, a few ticks each, so that all meet the same machine."""

from __future__ import annotations

import gc
import logging
from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

import numpy as np

from equipoise.bench.rows import Row

WARM_UP = 20  # ticks that are run and not counted
TURN = 50  # ticks in a row, so that a loop of its own meets caches as the tick before left them
Progress = Callable[[str, float], None]


class Contender(Protocol):
    """Something that is timed; it keeps its own state from tick to tick."""

    @property
    def turn(self) -> int:
        """How many ticks it is given at a time."""

    @property
    def failures(self) -> Mapping[str, int]:
        """How often it failed, by name of row."""

    @property
    def remarks(self) -> Mapping[str, str]:
        """The words of its rows."""

    def run(self, first: int, count: int) -> Mapping[str, Sequence[int]]:
        """Run ticks `first` to `first + count - 1`; return by name of row the time of each [ns]."""


def interleave(
    contenders: Sequence[Contender], ticks: int, report: Progress | None = None
) -> list[Row]:
    """Run all contenders for `ticks` ticks, interleaved, the collector frozen; return their rows.

    Who begins changes from turn to turn.
    """
    spent: dict[str, list[int]] = {}
    gc.collect()
    gc.freeze()
    gc.disable()
    logging.disable(logging.WARNING)  # a peer may say every tick that a limit is touched
    try:
        for k in range(ticks):
            begins = k % max(len(contenders), 1)
            for contender in (*contenders[begins:], *contenders[:begins]):
                if k % contender.turn == 0:
                    for name, ns in contender.run(k, min(contender.turn, ticks - k)).items():
                        spent.setdefault(name, []).extend(ns)
            if report is not None and k % 50 == 0:
                report("timing", k / ticks)
    finally:
        logging.disable(logging.NOTSET)
        gc.enable()
        gc.unfreeze()
    return [_row(name, ns, contenders) for name, ns in spent.items()]


def _row(name: str, ns: Sequence[int], contenders: Sequence[Contender]) -> Row:
    return row_of(
        name,
        ns[min(WARM_UP, len(ns) // 2) :],
        failures=sum(c.failures.get(name, 0) for c in contenders),
        remark=next((c.remarks[name] for c in contenders if name in c.remarks), ""),
    )


def row_of(name: str, ns: Sequence[int], *, failures: int = 0, remark: str = "") -> Row:
    """Return median and 99th percentile of times [ns] as a row."""
    us = np.asarray(ns, dtype=float) / 1000.0
    median, tail = float(np.median(us)), float(np.percentile(us, 99))
    return Row(name, round(median, 3), round(tail, 3), len(us), failures, remark)
