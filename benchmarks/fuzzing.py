"""Runs many seeded cases in workers that may hang or die, and counts how they end.

A case is a function of its seed and of a folder that is its own; it returns in a word how it
ended, and raises what it should not. A worker that takes too long or dies is replaced, and the
case counted as a hang or a crash.
"""

from __future__ import annotations

import argparse
import logging
import multiprocessing
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path

Case = Callable[[int, Path], str]
TRACEBACK, HANG, CRASH = "traceback", "hang", "crash"
FIRST = 300.0  # [s] a new worker may take until its first answer: it may have to compile


@dataclass
class Outcomes:
    """How often each ending came, and by seed what went wrong."""

    counts: Counter[str] = field(default_factory=Counter)
    bad: dict[int, str] = field(default_factory=dict)
    slowest: tuple[float, int] = (0.0, -1)

    def add(self, seed: int, word: str, detail: str, took: float) -> None:
        """Count one case."""
        self.counts[word] += 1
        self.slowest = max(self.slowest, (took, seed))
        if word in (TRACEBACK, HANG, CRASH):
            self.bad[seed] = f"{word} {detail}".strip()


def run_here(case: Case, seeds: Sequence[int], folder: Path) -> Outcomes:
    """Run cases in this process, without limits: for tests."""
    outcomes = Outcomes()
    for seed in seeds:
        begun = time.monotonic()
        word, detail = _ended(case, seed, folder)
        outcomes.add(seed, word, detail, time.monotonic() - begun)
    return outcomes


def run_apart(case: Case, seeds: Sequence[int], limit: float) -> Outcomes:
    """Run cases one by one in a worker, each for `limit` [s] at most."""
    outcomes, left, say = Outcomes(), list(seeds), time.monotonic()
    while left:
        ours, theirs = multiprocessing.Pipe()
        worker = multiprocessing.get_context("spawn").Process(
            target=_work, args=(case, left, theirs), daemon=True
        )
        worker.start()
        theirs.close()
        allowed = FIRST
        while left:
            begun = time.monotonic()
            try:
                if not ours.poll(allowed):
                    outcomes.add(left.pop(0), HANG, f"after {allowed:g} s", allowed)
                    break
                word, detail = ours.recv()
            except EOFError:
                worker.join(10.0)
                code = worker.exitcode
                outcomes.add(left.pop(0), CRASH, f"exit code {code}", time.monotonic() - begun)
                break
            took = time.monotonic() - begun if allowed != FIRST else 0.0
            outcomes.add(left.pop(0), word, detail, took)
            allowed = limit
            if time.monotonic() - say > 60.0:
                print(f"{len(seeds) - len(left)} of {len(seeds)}: {_told(outcomes)}", flush=True)
                say = time.monotonic()
        worker.kill()
        worker.join()
        ours.close()
    return outcomes


def main(case: Case, what: str, argv: Sequence[str] | None = None) -> int:
    """Run cases as the command line says; print the counts; return 1 if one went wrong."""
    parser = argparse.ArgumentParser(description=what)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0, help="of the first case")
    parser.add_argument("--limit", type=float, default=60.0, help="seconds a case may take")
    given = parser.parse_args(argv)
    outcomes = run_apart(case, range(given.seed, given.seed + given.count), given.limit)
    for seed, said in outcomes.bad.items():
        print(f"seed {seed}: {said}")
    took, seed = outcomes.slowest
    print(f"{what}: {_told(outcomes)}; the slowest took {took:.1f} s (seed {seed})")
    return 1 if outcomes.bad else 0


def _told(outcomes: Outcomes) -> str:
    counts = {word: outcomes.counts[word] for word in (TRACEBACK, HANG, CRASH)}
    counts |= dict(sorted(outcomes.counts.items()))
    return ", ".join(f"{count} {word}" for word, count in counts.items())


def _work(case: Case, seeds: Sequence[int], pipe: Connection) -> None:
    logging.disable(logging.CRITICAL)
    with tempfile.TemporaryDirectory() as folder:
        for seed in seeds:
            pipe.send(_ended(case, seed, Path(folder)))


def _ended(case: Case, seed: int, folder: Path) -> tuple[str, str]:
    try:
        return case(seed, folder), ""
    except Exception:
        return TRACEBACK, traceback.format_exc()
