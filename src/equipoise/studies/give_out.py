"""Gives the runs of a study to an engine and takes their results, until none is left."""

from __future__ import annotations

import os
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from equipoise.studies.batch import Batch
from equipoise.studies.chunks import ChunkSize
from equipoise.studies.engines.base import DiskFullError, Engine, Told
from equipoise.studies.folder import StudyFolder
from equipoise.studies.journal import Journal, Result
from equipoise.studies.plan import RunId, StudyRun
from equipoise.studies.schema import StudySpec

LOOK = 0.5  # [s] between two looks at an engine that says nothing


class Source(Protocol):
    """Where runs come from: a plan."""

    @property
    def most(self) -> int:
        """How many runs there are at most."""

    def first(self) -> Iterator[StudyRun]:
        """Yield the runs that need no result."""

    def after(self, run: RunId, *, good: bool) -> StudyRun | None:
        """Return the run that follows from a result."""


class Listed:
    """Runs that are all known."""

    def __init__(self, runs: Sequence[StudyRun]) -> None:
        self.runs, self.most = runs, len(runs)

    def first(self) -> Iterator[StudyRun]:
        """Yield them."""
        return iter(self.runs)

    def after(self, run: RunId, *, good: bool) -> StudyRun | None:
        """Return nothing: nothing follows."""
        return None


@dataclass(frozen=True)
class Standing:
    """How far a study is: runs done (`before` of them by earlier calls), at most, good, and so on.

    `left` [s]: how long it will still take at the rate of this call, None while unknown.
    """

    done: int
    most: int
    before: int
    good: int
    slots: int
    left: float | None


Report = Callable[[Standing], None]


@dataclass
class State:
    """What is known in the middle of a study."""

    source: Source
    results: dict[str, Result]
    queue: deque[StudyRun] = field(default_factory=deque)
    given: dict[str, Batch] = field(default_factory=dict)
    before: int = 0
    good: int = 0
    began: float = field(default_factory=time.monotonic)

    def begin(self) -> None:
        """Queue the runs of the source that have no result."""
        self.before = len(self.results)
        self.good = sum(bool(one["row"]["good"]) for one in self.results.values())
        for run in self.source.first():
            self.add(run)

    def add(self, run: StudyRun | None) -> None:
        """Queue a run, or if it is done what follows from it."""
        while run is not None:
            result = self.results.get(str(run.id))
            if result is None:
                self.queue.append(run)
                return
            run = self._follow(run.id, result)

    def take(self, result: Result) -> bool:
        """Take a result; say whether it is new."""
        if result["id"] in self.results:
            return False
        self.results[result["id"]] = result
        self.good += bool(result["row"]["good"])
        self.add(self._follow(RunId.read(result["id"]), result))
        return True

    def _follow(self, run_id: RunId, result: Result) -> StudyRun | None:
        return self.source.after(run_id, good=bool(result["row"]["good"]))

    def standing(self, slots: int) -> Standing:
        """Say how far it is."""
        now = len(self.results) - self.before
        spent = time.monotonic() - self.began
        most = self.source.most
        left = (most - len(self.results)) * spent / now if now else None
        return Standing(len(self.results), most, self.before, self.good, slots, left)


def give_out(
    state: State, engine: Engine, folder: StudyFolder, study: StudySpec, report: Report
) -> None:
    """Run all runs of a state that have no result; results are kept in the folder.

    Raises: `DiskFullError`, `EngineLostError`.
    """
    text, token = study.model_dump_json(), folder.token
    chunk = ChunkSize(study.engine.chunk if engine.waiting_most > 1.0 else 0.0)
    journal, client, count = Journal(folder.rows), os.urandom(4).hex(), 0
    report(state.standing(engine.slots))
    while state.queue or state.given:
        left = len(state.queue) + sum(len(batch.runs) for batch in state.given.values())
        while state.queue and len(state.given) < engine.waiting_most * engine.slots:
            size = min(chunk.runs(left, engine.slots), len(state.queue))
            runs = tuple(state.queue.popleft() for _ in range(size))
            count += 1
            batch = Batch(f"{client}-{count}", runs, text, str(folder.path.resolve()), token)
            state.given[batch.name] = batch
            engine.submit(batch)
        for told in engine.wait(LOOK):
            _hear(state, told, journal, folder)
            for result in told.results:
                chunk.took(result["times"].get("wall", 0.0))
        report(state.standing(engine.slots))


def _hear(state: State, told: Told, journal: Journal, folder: StudyFolder) -> None:
    """Take what an engine told: results, the end of a batch, the loss of a worker."""
    for result in told.results:
        if state.take(result) and not told.kept:
            try:
                journal.end(result)
            except OSError as error:
                raise DiskFullError(error.strerror or str(error)) from error
    if told.lost:
        folder.tell("worker lost", batch=told.batch.name)
    if told.over:
        state.given.pop(told.batch.name, None)
        for run in told.batch.runs:
            if str(run.id) not in state.results:
                state.queue.append(run)
