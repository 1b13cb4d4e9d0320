"""A study from the first run to its tables: gives out runs, takes results, goes on where it was."""

from __future__ import annotations

import os
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from equipoise.errors import RunLogError
from equipoise.studies.batch import Batch
from equipoise.studies.chunks import ChunkSize
from equipoise.studies.engines.base import DiskFullError, Engine, EngineLostError, Told
from equipoise.studies.engines.make import make_engine
from equipoise.studies.folder import StudyFolder
from equipoise.studies.journal import Journal, Result, read_journals
from equipoise.studies.plan import Plan, RunId, StudyRun
from equipoise.studies.results import write_design, write_tables
from equipoise.studies.runner import Runner
from equipoise.studies.schema import StudySpec

LOOK = 0.5  # [s] between two looks at an engine that says nothing


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
class _State:
    """What is known in the middle of a study."""

    plan: Plan
    results: dict[str, Result]
    queue: deque[StudyRun] = field(default_factory=deque)
    given: dict[str, Batch] = field(default_factory=dict)
    before: int = 0
    began: float = field(default_factory=time.monotonic)

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
        self.add(self._follow(RunId.read(result["id"]), result))
        return True

    def _follow(self, run_id: RunId, result: Result) -> StudyRun | None:
        return self.plan.after(run_id, good=bool(result["row"]["good"]))

    def standing(self, slots: int) -> Standing:
        """Say how far it is."""
        now = len(self.results) - self.before
        spent = time.monotonic() - self.began
        most = self.plan.most
        left = (most - len(self.results)) * spent / now if now else None
        good = sum(bool(one["row"]["good"]) for one in self.results.values())
        return Standing(len(self.results), most, self.before, good, slots, left)


def run_study(
    study: StudySpec,
    out: Path | str,
    *,
    report: Report | None = None,
    waiting: Callable[[], None] | None = None,
    modules: Sequence[str] = (),
) -> StudyFolder:
    """Run what is not yet done of a study into a folder, and write its tables.

    The same call goes on where an earlier one was ended, by whatever. `report` is told how far it
    is, `waiting` if workers of an earlier call still work. `modules` are imported by the workers.
    Raises: `InputError`; `RunLogError` if the disk refuses or the engine is lost: what is done is
    kept then, as with Ctrl-C.
    """
    Runner(study).check()
    folder = StudyFolder(out)
    folder.open(study)
    with folder.as_only_client(waiting or (lambda: None)):
        state = _begin(study, folder)
        engine: Engine | None = None
        try:
            if state.queue:
                engine = make_engine(study, _examples(state), modules)
                _run(state, engine, folder, study, report or (lambda standing: None))
        except DiskFullError as error:
            kept = f"{len(state.results)} runs are kept"
            raise RunLogError(
                f"{folder.path}: {error}. {kept}; make room, and the same command goes on."
            ) from error
        except EngineLostError as error:
            raise RunLogError(
                f"{error}. {len(state.results)} runs are kept; the same command goes on."
            ) from error
        finally:
            if engine is not None:
                engine.close()
            _write(folder, study, state)
        folder.tell("done", runs=len(state.results))
    return folder


def _begin(study: StudySpec, folder: StudyFolder) -> _State:
    noted = read_journals(folder.rows)
    try:
        Journal(folder.rows).forgive(noted.broken)  # they ended with the client they had
        folder.tell("begin", client=os.getpid(), done=len(noted.results))
        write_design(folder, study)
    except OSError as error:
        raise RunLogError(f"Cannot write in {folder.path}: {error.strerror}.") from error
    state = _State(Plan(study), noted.results, before=len(noted.results))
    for run in state.plan.first():
        state.add(run)
    return state


def _run(
    state: _State, engine: Engine, folder: StudyFolder, study: StudySpec, report: Report
) -> None:
    text, token = study.model_dump_json(), folder.token
    chunk = ChunkSize(study.engine.chunk if engine.waiting_most > 1.0 else 0.0)
    journal, client, count = Journal(folder.rows), os.urandom(4).hex(), 0
    report(state.standing(engine.slots))
    while state.queue or state.given:
        while state.queue and len(state.given) < engine.waiting_most * engine.slots:
            left = len(state.queue) + sum(len(batch.runs) for batch in state.given.values())
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


def _hear(state: _State, told: Told, journal: Journal, folder: StudyFolder) -> None:
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


def _write(folder: StudyFolder, study: StudySpec, state: _State) -> None:
    try:
        write_tables(folder, study, state.results)
    except OSError as error:
        raise RunLogError(
            f"Cannot write the tables in {folder.path}: {error.strerror}. The results are kept; "
            "make room, and the same command goes on."
        ) from error


def _examples(state: _State) -> tuple[StudyRun, ...]:
    """Return one run of each controller, to see with whether kernels have to be compiled."""
    found: dict[str, StudyRun] = {}
    for run in state.queue:
        found.setdefault(run.controller, run)
    return tuple(found.values())
