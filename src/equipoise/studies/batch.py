"""What a worker does with the runs it is given, on whichever machine: the same for all engines."""

from __future__ import annotations

import os
import warnings
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from equipoise.compiled import watch_compilation
from equipoise.studies.folder import FAILED, StudyFolder
from equipoise.studies.journal import Journal, Noted, Result, read_journals
from equipoise.studies.plan import StudyRun
from equipoise.studies.runner import LOST, Runner, failed
from equipoise.studies.schema import StudySpec

MOST_KILLS = 2  # a run that ends so many workers is not tried again
BEGUN = "begun"


class CompiledError(Exception):
    """Kernels were compiled by this worker, which is not to be used any more.

    A process that compiles has other copies of a kernel at hand than those that load what it kept,
    and its last digits may differ: results are made by the others.
    """


@dataclass(frozen=True)
class Batch:
    """Runs that a worker does one after the other; `name` is its own, `study` as JSON.

    `folder` is where the study lies, as the client sees it.
    """

    name: str
    runs: tuple[StudyRun, ...]
    study: str
    folder: str
    token: str


@cache
def runner_of(study: str) -> Runner:
    """Return the runner of this process for a study."""
    return Runner(StudySpec.model_validate_json(study))


@cache
def journal_in(folder: str) -> Journal:
    """Return the journal of this process in a folder."""
    return Journal(Path(folder))


def work_on(
    batch: Batch, told: Callable[[Result], None] | None = None
) -> tuple[list[Result], bool]:
    """Do the runs of a batch that are not done yet; return all results, and whether they are kept.

    A result is kept as soon as it is there, if the study's folder is to be seen from here; a run
    that ended its worker twice counts as failed. Raises: `OSError` if the disk refuses,
    `CompiledError`.
    """
    folder = StudyFolder(batch.folder)
    if not folder.has(batch.token):
        return [runner_of(batch.study).run(run) for run in batch.runs], False
    results: list[Result] = []
    with folder.at_work(), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a robot's warnings were told before
        journal, noted = journal_in(str(folder.rows)), Noted()
        if _was_begun(folder, batch.name):
            noted = read_journals(folder.rows, [str(run.id) for run in batch.runs])
        broken = noted.broken
        for run in batch.runs:
            key = str(run.id)
            result = noted.results.get(key) or _done(batch, run, journal, broken[key])
            results.append(result)
            if told is not None:
                told(result)
    return results, True


def _done(batch: Batch, run: StudyRun, journal: Journal, kills: int) -> Result:
    key = str(run.id)
    compiling: list[bool] = []
    if kills >= MOST_KILLS:
        result = failed(run, LOST, f"{kills} workers ended during this run")
    else:
        journal.begin(key)
        with watch_compilation(compiling.append):
            result = runner_of(batch.study).run(run, Path(batch.folder) / FAILED)
    if compiling:
        journal.forgive(Counter([key]))
        raise CompiledError(os.getpid())
    journal.end(result)
    return result


def _was_begun(folder: StudyFolder, name: str) -> bool:
    """Say whether another worker began this batch before, and note that it is begun now."""
    place = folder.path / BEGUN
    place.mkdir(exist_ok=True)
    try:
        os.close(os.open(place / name, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o644))
    except FileExistsError:
        return True
    return False


def compiles(study: str, runs: tuple[StudyRun, ...]) -> bool:
    """Run some runs for a moment and let them fall; return whether kernels had to be compiled."""
    seen: list[bool] = []
    with watch_compilation(seen.append):
        for run in runs:
            runner_of(study).try_out(run)
    return bool(seen)
