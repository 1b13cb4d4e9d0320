"""The engine `dask`: the bytes of the engine `cores`, also where workers see no common folder."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any

import made_up
import pytest
from short import short

from equipoise.studies import drive
from equipoise.studies.chunks import ChunkSize
from equipoise.studies.folder import ROWS, StudyFolder
from equipoise.studies.journal import read_journals
from equipoise.studies.results import RESULTS
from equipoise.studies.runner import Runner

pytest.importorskip("pyarrow")


def test_batches_are_as_long_as_wanted_and_short_at_the_end() -> None:
    size = ChunkSize(25.0)
    assert size.runs(1000, 4) == 1  # nothing is known yet
    for _ in range(200):
        size.took(0.5)
    assert size.runs(100_000, 4) == 50
    assert size.runs(40, 4) == 5
    assert size.runs(1, 4) == 1
    assert ChunkSize(0.0).runs(100, 1) == 1


def test_the_size_follows_runs_that_become_longer() -> None:
    size = ChunkSize(20.0)
    for seconds in [0.1] * 100 + [2.0] * 100:
        size.took(seconds)
    assert 9 <= size.runs(10_000, 2) <= 11


@pytest.mark.slow
def test_a_cluster_finds_the_same_bytes(tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    for name, engine in (("cores", "{workers: 1}"), ("dask", "{kind: dask, workers: 2}")):
        spec = short(tmp_path, f"engine={engine}", "designs={main: {kind: sobol, points: 4}}")
        drive.run_study(spec, tmp_path / name)
    whole = [(tmp_path / name / RESULTS).read_bytes() for name in ("cores", "dask")]
    assert whole[0] == whole[1]


def test_results_of_workers_without_the_folder_are_kept_by_the_client(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Over a real scheduler; the runs are made up, the folder is hidden from the workers."""
    distributed = pytest.importorskip("distributed")
    from equipoise.studies.engines import dask_cluster

    lock = threading.Lock()

    def cluster(spec: Any) -> Any:
        return distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=False, dashboard_address=None
        )

    def run(self: Runner, one: Any, logs: Any = None) -> Any:
        with lock:
            return made_up.result(one, 0.001 * one.id.point)

    monkeypatch.setattr(dask_cluster, "_made", cluster)
    monkeypatch.setattr(dask_cluster, "warm_up", lambda *given: None)
    monkeypatch.setattr(StudyFolder, "has", lambda self, token: False)
    monkeypatch.setattr(Runner, "run", run)
    spec = short(tmp_path, "engine={kind: dask}", "designs={main: {kind: sobol, points: 40}}")
    drive.run_study(spec, tmp_path / "study")
    noted = read_journals(tmp_path / "study" / ROWS)
    assert (len(noted.results), noted.repeated) == (80, [])
    assert not noted.begun  # no worker wrote
