"""A study from the first run to its tables; it goes on where an earlier call was ended."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from equipoise.errors import RunLogError
from equipoise.studies.engines.base import DiskFullError, Engine, EngineLostError
from equipoise.studies.engines.make import make_engine
from equipoise.studies.folder import StudyFolder
from equipoise.studies.give_out import Report, State, give_out
from equipoise.studies.journal import Journal, Noted, read_journals
from equipoise.studies.plan import Plan, StudyRun
from equipoise.studies.results import write_design, write_tables
from equipoise.studies.runner import Runner
from equipoise.studies.schema import StudySpec


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
                with told_what_is_kept(folder, state):
                    engine = make_engine(study, _examples(state), modules)
                    give_out(state, engine, folder, study, report or (lambda standing: None))
        finally:
            if engine is not None:
                engine.close()
            _write(folder, study, state)
        folder.tell("done", runs=len(state.results))
    return folder


def pick_up(folder: StudyFolder) -> Noted:
    """Return what earlier calls have done in a folder that is ours now. Raises: `RunLogError`."""
    try:
        noted = read_journals(folder.rows)
        Journal(folder.rows).forgive(noted.broken)  # they ended with the client they had
        folder.tell("begin", client=os.getpid(), done=len(noted.results))
    except OSError as error:
        raise RunLogError(f"Cannot write in {folder.path}: {error.strerror}.") from error
    return noted


@contextmanager
def told_what_is_kept(folder: StudyFolder, state: State) -> Iterator[None]:
    """Say of a full disk, or an engine that is gone, what is kept. Raises: `RunLogError`."""
    kept = "runs are kept"
    try:
        yield
    except DiskFullError as error:
        raise RunLogError(
            f"{folder.path}: {error}. {len(state.results)} {kept}; make room, and the same command "
            "goes on."
        ) from error
    except EngineLostError as error:
        raise RunLogError(
            f"{error}. {len(state.results)} {kept}; the same command goes on."
        ) from error


def _begin(study: StudySpec, folder: StudyFolder) -> State:
    noted = pick_up(folder)
    try:
        write_design(folder, study)
    except OSError as error:
        raise RunLogError(f"Cannot write in {folder.path}: {error.strerror}.") from error
    state = State(Plan(study), noted.results)
    state.begin()
    return state


def _write(folder: StudyFolder, study: StudySpec, state: State) -> None:
    try:
        write_tables(folder, study, state.results)
    except OSError as error:
        raise RunLogError(
            f"Cannot write the tables in {folder.path}: {error.strerror}. The results are kept; "
            "make room, and the same command goes on."
        ) from error


def _examples(state: State) -> tuple[StudyRun, ...]:
    """Return one run of each controller, to see with whether kernels have to be compiled."""
    found: dict[str, StudyRun] = {}
    for run in state.queue:
        found.setdefault(run.controller, run)
    return tuple(found.values())
