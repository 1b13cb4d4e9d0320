"""How busy a study keeps many slots: a real Dask scheduler and client, workers whose runs sleep.

`python benchmarks/study_slots.py [--slots 1000] [--seconds 300] [--chunk 25] [--simulate]`

Emulated are the runs alone: each sleeps for a time drawn around `--run` seconds instead of being
computed. Everything else is what a study does: scheduler, as many Dask workers (each with its one
thread, all in one process of this machine), the client that gives out batches and takes results,
the journals on disk. Off is what each worker measures of its own process (profile, memory): here
they are all in one. The work is so many seconds a slot. Efficiency is the time slept over slots
times wall time, counted from the first batch to the last result; workers are started before. Here
all of that shares the cores of one machine, which a cluster would not.

`--simulate` computes instead of waiting: the same sizes of batches from the same class, the same
number at hand for each slot, run times drawn alike, and one scheduler that takes `--task` seconds
for each batch, one after the other (3.3 ms: 300 a second, the slow end of what Dask does).
"""

from __future__ import annotations

import argparse
import heapq
import json
import random
import resource
import sys
import tempfile
import time
from collections import deque
from pathlib import Path
from typing import Any

from equipoise.studies.batch import runner_of
from equipoise.studies.chunks import ChunkSize
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


def simulated(given: argparse.Namespace) -> float:
    """Return the efficiency that follows from sizes of batches and the time of the scheduler."""
    runs = round(given.slots * given.seconds / given.run)
    times = deque(seconds_of(run, given.run) for run in Plan(study(runs, given.chunk)).first())
    work, left, chunk = sum(times), runs, ChunkSize(given.chunk)
    now = served = 0.0  # of the client; until when the scheduler has served all before
    waiting: list[tuple[float, list[float]]] = []  # when a batch is at hand, its runs
    free = [0.0] * given.slots  # when each slot has nothing to do
    ended: list[tuple[float, list[float]]] = []  # of the batches that are worked on
    last = 0.0
    while left:
        while times and len(waiting) + len(ended) < DaskCluster.waiting_most * given.slots:
            size = min(chunk.runs(left, given.slots), len(times))
            served = max(served, now) + given.task
            waiting.append((served, [times.popleft() for _ in range(size)]))
        waiting.sort(key=lambda one: one[0], reverse=True)
        while waiting and free:
            at_hand, batch = waiting.pop()
            heapq.heappush(ended, (max(heapq.heappop(free), at_hand) + sum(batch), batch))
        now, batch = heapq.heappop(ended)
        heapq.heappush(free, now)
        last, left = max(last, now), left - len(batch)
        for seconds in batch:
            chunk.took(seconds)
    return work / (given.slots * last)


def main(arguments: list[str] | None = None) -> int:
    """Measure the efficiency."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--slots", type=int, default=1000)
    parser.add_argument("--seconds", type=float, default=300.0, help="of work a slot")
    parser.add_argument("--run", type=float, default=1.0, help="mean time of a run [s]")
    parser.add_argument("--chunk", type=float, default=25.0, help="[s]")
    parser.add_argument("--simulate", action="store_true", help="compute instead of waiting")
    parser.add_argument("--task", type=float, default=1.0 / 300.0, help="of the scheduler [s]")
    given = parser.parse_args(arguments)
    if given.simulate:
        print(json.dumps({"slots": given.slots, "efficiency": round(simulated(given), 3)}))
        return 0
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
