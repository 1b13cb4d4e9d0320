"""Studies that really run: any number of workers, any interruption, the same bytes."""

from __future__ import annotations

import json
import os
import signal
import threading
import time
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from short import short

from equipoise import run_scenario
from equipoise.control.kinds import CONTROLLERS
from equipoise.errors import InputError, RunLogError
from equipoise.scenarios import resolved_text
from equipoise.studies import drive
from equipoise.studies.engines.base import DiskFullError
from equipoise.studies.engines.cores import Cores
from equipoise.studies.folder import EVENTS, ROWS
from equipoise.studies.give_out import Standing
from equipoise.studies.journal import read_journals
from equipoise.studies.plan import Plan, StudyRun
from equipoise.studies.results import RESULTS, load_results
from equipoise.studies.runner import LOST, NOT_RUN, Runner

for _package in ("pyarrow",):
    pytest.importorskip(_package)


@pytest.fixture(scope="module")
def calm(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of the study, run by two workers that nobody disturbs."""
    place = tmp_path_factory.mktemp("calm")
    drive.run_study(short(place, "engine.workers=2"), place / "study")
    return place / "study"


def test_a_run_in_memory_is_the_run_that_is_logged(tmp_path: Path) -> None:
    """Every metric of every controller has the bits of `equipoise run` on the same scenario."""
    spec = short(tmp_path)
    runner = Runner(spec)
    runs = [run for run in Plan(spec).first() if run.id.design == "main"][:3]
    for run in runs:  # the second and third start from what the first one found
        file = tmp_path / f"{run.id.contender}{run.id.point}.yaml"
        file.write_text(resolved_text(runner.scenario(run)))
        logged = run_scenario(str(file), out=tmp_path / file.stem, figures=False)
        for name, value in runner.run(run)["row"]["metrics"].items():
            assert value == logged.metrics[name]["value"], name


def test_what_failed_leaves_a_log_and_no_more_than_wanted(calm: Path) -> None:
    results = load_results(calm)
    assert not results["good"].all()
    kept = sorted((calm / "failed" / "slow").iterdir())
    assert 0 < len(kept) <= 10
    assert (kept[0] / "run.mcap").is_file()


def test_one_worker_that_is_killed_and_a_client_that_is_ended_make_no_difference(
    tmp_path: Path, calm: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    engines: list[Cores] = []

    def make(study: Any, runs: Any, modules: Any) -> Cores:
        engines.append(Cores(1, study.model_dump_json(), runs, modules))
        return engines[-1]

    def disturb(standing: Standing) -> None:
        if standing.done >= 2 and not killed:
            killed.append(engines[0].processes[0])
            os.kill(killed[0], signal.SIGKILL)
        if standing.done >= 6:
            raise KeyboardInterrupt

    killed: list[int] = []
    monkeypatch.setattr(drive, "make_engine", make)
    spec, place = short(tmp_path), tmp_path / "study"
    with pytest.raises(KeyboardInterrupt):
        drive.run_study(spec, place, report=disturb)
    assert killed
    assert '"worker lost"' in (place / EVENTS).read_text()
    before = set(read_journals(place / ROWS).results)
    assert len(load_results(place)) >= 6  # what was done can be looked at
    drive.run_study(spec, place)
    noted = read_journals(place / ROWS)
    assert before < set(noted.results)
    assert noted.repeated == []
    assert (place / RESULTS).read_bytes() == (calm / RESULTS).read_bytes()


def test_nothing_runs_when_all_is_done(calm: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(drive, "make_engine", None)
    drive.run_study(short(calm.parent), calm)


def test_a_folder_belongs_to_one_study_and_one_source(
    calm: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(InputError, match="holds another study"):
        drive.run_study(short(tmp_path, "seeds=2"), calm)
    monkeypatch.setattr("equipoise.studies.folder.source_hash", lambda: "other")
    with pytest.raises(InputError, match="begun with other code"):
        drive.run_study(short(tmp_path), calm)


def test_a_second_client_is_refused(calm: Path) -> None:
    from equipoise.studies.folder import StudyFolder

    with (
        StudyFolder(calm).as_only_client(lambda: None),
        pytest.raises(InputError, match="running already"),
    ):
        drive.run_study(short(calm.parent), calm)


def test_a_client_waits_for_workers_of_one_that_is_gone(tmp_path: Path) -> None:
    from equipoise.studies.folder import StudyFolder

    folder, told = StudyFolder(tmp_path), []
    leave, there = threading.Event(), threading.Event()

    def work() -> None:
        with folder.at_work():
            there.set()
            leave.wait(20.0)

    worker = threading.Thread(target=work)
    worker.start()
    there.wait(20.0)

    def waiting() -> None:
        told.append(time.monotonic())
        leave.set()

    with folder.as_only_client(waiting):
        assert len(told) == 1
    worker.join()


def test_a_run_that_ends_its_worker_twice_is_a_failed_row(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A controller that ends its process: the run is tried twice, the study goes on."""
    (tmp_path / "deadly.py").write_text(DEADLY)
    spec = short(
        tmp_path,
        "controllers.deadly={set: {control.kind: deadly}}",
        "designs={main: {kind: sobol, points: 1}}",
        "engine.workers=1",
    )
    monkeypatch.syspath_prepend(str(tmp_path))
    import_module("deadly")
    try:
        drive.run_study(spec, tmp_path / "study", modules=["deadly"])
    finally:
        CONTROLLERS.pop("deadly")
    results = load_results(tmp_path / "study")
    causes = dict(zip(results["controller"], results["cause"], strict=True))
    assert causes["deadly"] == LOST
    assert causes["quick"] != LOST
    begun = read_journals(tmp_path / "study" / ROWS).begun
    assert sorted(begun.values()) == [1, 1, 2]


DEADLY = """
import os
from equipoise.control.kinds import register_controller


def make(robot, contacts, gains, period):
    from equipoise import PassivityController

    class Deadly(PassivityController):
        def step(self, t, measured, reference):
            if t > 0.02:
                os._exit(7)
            return super().step(t, measured, reference)

    return Deadly(robot, contacts, gains, period)


register_controller("deadly", make)
"""


def test_a_run_that_raises_is_a_failed_row(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def simulation(self: Runner, run: StudyRun) -> None:
        raise ZeroDivisionError("of no use")

    monkeypatch.setattr(Runner, "simulation", simulation)
    spec = short(tmp_path)
    row = Runner(spec).run(next(iter(Plan(spec).first())))["row"]
    assert (row["cause"], row["why"]) == (NOT_RUN, "ZeroDivisionError: of no use")
    assert not row["stands"]


def test_a_full_disk_is_told_and_what_is_there_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Full:
        slots, waiting_most = 1, 1.0

        def submit(self, batch: Any) -> None:
            pass

        def wait(self, seconds: float) -> list[Any]:
            raise DiskFullError("No space left on device")

        def close(self) -> None:
            pass

    monkeypatch.setattr(drive, "make_engine", lambda *given: Full())
    with pytest.raises(RunLogError, match=r"No space left on device\. 0 runs are kept; make room"):
        drive.run_study(short(tmp_path), tmp_path / "study")


def test_where_results_come_from_is_noted(calm: Path) -> None:
    told = json.loads((calm / "provenance.json").read_text())
    assert {"equipoise", "source", "python", "packages", "processor", "cores"} <= set(told)
    assert len(told["source"]) == 64
