"""How busy a study keeps many slots: a real Dask scheduler and client, workers whose runs sleep.

`python benchmarks/study_slots.py [--slots 1000] [--seconds 300] [--chunk 25]`

Emulated are the runs alone: each sleeps for a time drawn around `--run` seconds instead of being
computed. Everything else is what a study does: scheduler, as many Dask workers (each with its one
thread, all in one process of this machine), the client that gives out batches and takes results,
the journals on disk. Off is what each worker measures of its own process (profile, memory): here
they are all in one. The work is so many seconds a slot. Efficiency is the time slept over slots
times wall time, counted from the first batch to the last result; workers are started before. Here
all of that shares the cores of one machine, which a cluster would not.
"""

from __future__ import annotations

import argparse
import json
import random
import resource
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from equipoise.studies.batch import runner_of
from equipoise.studies.engines import dask_cluster
from equipoise.studies.engines.dask_cluster import DaskCluster
from equipoise.studies.folder import StudyFolder
from equipoise.studies.give_out import State, give_out
from equipoise.studies.plan import Plan, StudyRun
from equipoise.studies.runner import Runner, described
from equipoise.studies.schema import StudySpec

SPREAD = 0.4  # of the logarithm of a run's time
FILES = 16_000  # that may be open


def study(points: int, chunk: float) -> StudySpec:
    """Return a study of so many runs."""
    return StudySpec.model_validate(
        {
            "name": "slots",
            "scenario": "press",
            "controllers": {"one": {}},
            "parameters": {"x": {"path": "disturbances.mass_scale", "uniform": [0.5, 2.0]}},
            "designs": {"main": {"kind": "sobol", "points": points}},
            "engine": {"kind": "dask", "chunk": chunk},
        }
    )


def seconds_of(run: StudyRun, mean: float) -> float:
    """Return how long a run takes: the same whenever it is asked, log-normal around the mean."""
    draw = random.Random(run.id.point).gauss(-0.5 * SPREAD**2, SPREAD)
    return mean * 2.718281828459045**draw


def sleeping(mean: float) -> Any:
    """Return what stands for a run."""

    def run(self: Runner, one: StudyRun, logs: Path | None = None) -> dict[str, Any]:
        seconds = seconds_of(one, mean)
        time.sleep(seconds)
        row = {"stands": True, "good": True, "cause": "", "why": "", "t_end": 1.0, "metrics": {}}
        return {"id": str(one.id), "row": described(one) | row, "times": {"wall": seconds}}

    return run


def cluster_of(slots: int) -> Any:
    """Return a cluster of so many workers with one thread each, in this process."""
    import dask
    import distributed

    dask.config.set(
        {  # what every worker would measure of its own process, here a thousand times of one
            "distributed.worker.profile.enabled": False,
            "distributed.admin.system-monitor.interval": "1h",
            "distributed.admin.tick.limit": "60s",
        }
    )
    return distributed.LocalCluster(
        n_workers=slots, threads_per_worker=1, processes=False, dashboard_address=None,
        silence_logs=50, memory_limit=0,
    )  # fmt: skip


def main(arguments: list[str] | None = None) -> int:
    """Measure the efficiency."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--slots", type=int, default=1000)
    parser.add_argument("--seconds", type=float, default=300.0, help="of work a slot")
    parser.add_argument("--run", type=float, default=1.0, help="mean time of a run [s]")
    parser.add_argument("--chunk", type=float, default=25.0, help="[s]")
    given = parser.parse_args(arguments)
    resource.setrlimit(resource.RLIMIT_NOFILE, (FILES, FILES))
    spec = study(round(given.slots * given.seconds / given.run), given.chunk)
    Runner.run = sleeping(given.run)  # type: ignore[method-assign]
    dask_cluster._made = lambda engine: cluster_of(given.slots)
    dask_cluster.warm_up = lambda *nothing: None
    with tempfile.TemporaryDirectory() as place:
        folder = StudyFolder(Path(place) / "study")
        folder.open(spec)
        state = State(Plan(spec), {})
        state.begin()
        runs = [seconds_of(run, given.run) for run in state.queue]
        runner_of(spec.model_dump_json())  # a worker's own affair, here it would be that of all
        began = time.monotonic()
        engine = DaskCluster(spec.engine, spec.model_dump_json(), ())
        started = time.monotonic() - began
        began, cpu = time.monotonic(), time.process_time()
        give_out(state, engine, folder, spec, lambda standing: None)
        wall, cpu = time.monotonic() - began, time.process_time() - cpu
        engine.close()
    efficiency = sum(runs) / (given.slots * wall)
    print(
        json.dumps(
            {
                "slots": given.slots,
                "runs": len(state.results),
                "workers started in [s]": round(started, 1),
                "wall [s]": round(wall, 1),
                "work a slot [s]": round(sum(runs) / given.slots, 1),
                "efficiency": round(efficiency, 3),
                "processor time of all here [s]": round(cpu, 1),
            }
        )
    )
    return 0 if len(state.results) == len(runs) else 1


if __name__ == "__main__":
    sys.exit(main())
