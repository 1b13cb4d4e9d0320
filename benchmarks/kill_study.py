"""A study whose workers and client are killed: nothing is lost, nothing that finished runs again.

`python benchmarks/kill_study.py [--runs 400] [--workers 4] [--kills 2] [--engine cores]`

A study of short runs is begun as a process of its own. After a third of the runs some of its
workers get SIGKILL, after two thirds the client does (with `dask` its whole process group: the
cluster is the client's). The same command is then given again. What is counted comes from the
journals, in which every process notes each run that it begins and ends: lost (asked for, no
result), repeated (ended twice). The results must have the bytes of those of a study of the same
points that was left alone, with another number of workers. Ends with 1 if anything is wrong.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from equipoise.studies.folder import ROWS
from equipoise.studies.journal import read_journals
from equipoise.studies.results import RESULTS

LOOK = 0.05  # [s]
LONGEST = 3600.0  # [s]
STUDY = """
name: killed
scenario: press
set:
  physics.engine: {physics}
  duration: {duration}
  acceptance.after: 0.05
  disturbances.payloads: [{{mass: 1.0, frame: right_palm}}]
controllers: {{slow: {{set: {{control.gains.alpha: 5.0}}}}, quick: {{}}}}
parameters:
  load: {{path: disturbances.payloads.0.mass, uniform: [0.01, 10.0]}}
  delay: {{path: faults.measurement_delay, uniform: [0.0, 0.005]}}
designs: {{main: {{kind: sobol, points: {points}}}}}
good: {{path_error: {{max: 0.02}}}}
logs: 0
"""


def begin(file: Path, out: Path, workers: int, engine: str) -> subprocess.Popen[bytes]:
    """Begin the study as a process (and group) of its own."""
    return subprocess.Popen(
        [
            *(sys.executable, "-m", "equipoise.cli", "study", str(file), "--out", str(out)),
            *("--no-report", "--workers", str(workers), "--set", f"engine.kind={engine}"),
            *("--set", "engine.chunk=3"),
        ],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
        start_new_session=True,
    )


def done(out: Path) -> int:
    """Return how many runs have ended."""
    return len(read_journals(out / ROWS).results) if (out / ROWS).is_dir() else 0


def wait_for(out: Path, count: int, client: subprocess.Popen[bytes]) -> None:
    """Wait until so many runs have ended."""
    limit = time.monotonic() + LONGEST
    while done(out) < count:
        if client.poll() is not None or time.monotonic() > limit:
            raise SystemExit(f"the study ended with {client.returncode} at {done(out)} runs")
        time.sleep(LOOK)


def workers_of(out: Path) -> list[int]:
    """Return the processes that have noted runs and live."""
    pids = {int(path.name.split("-")[-2]) for path in (out / ROWS).glob("*.jsonl")}
    return [pid for pid in sorted(pids) if _lives(pid)]


def _lives(pid: int) -> bool:
    try:
        state = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8")
    except OSError:
        return False
    return state.rpartition(")")[2].split()[0] != "Z"


def kill_in_the_middle(file: Path, out: Path, given: argparse.Namespace) -> list[str]:
    """Kill workers, then the client; begin again and let it end; return what was done."""
    told = []
    client = begin(file, out, given.workers, given.engine)
    wait_for(out, given.runs // 3, client)
    victims = [pid for pid in workers_of(out) if pid != client.pid][-given.kills :]
    for pid in victims:
        os.kill(pid, signal.SIGKILL)
    told.append(f"{len(victims)} of {given.workers} workers killed at {done(out)} runs")
    wait_for(out, 2 * given.runs // 3, client)
    if given.engine == "dask":
        os.killpg(client.pid, signal.SIGKILL)
    else:
        client.kill()
    client.wait()
    time.sleep(1.0)
    orphans = workers_of(out)
    before = done(out)
    told.append(f"client killed at {before} runs; {len(orphans)} workers live on")
    time.sleep(1.0)
    told.append(f"{done(out) - before} more runs ended without it")
    client = begin(file, out, given.workers, given.engine)
    if client.wait(LONGEST) != 0:
        raise SystemExit("the study did not go on")
    return told


def main(arguments: list[str] | None = None) -> int:
    """Kill a study, and compare."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=400, help="an even number")
    parser.add_argument("--workers", type=int, default=4)
    parser.add_argument("--kills", type=int, default=2)
    parser.add_argument("--engine", choices=["cores", "dask"], default="cores")
    parser.add_argument("--duration", type=float, default=0.1, help="of a run [s]")
    parser.add_argument("--physics", choices=["rigid", "mujoco"], default="mujoco")
    given = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as place:
        file, killed, whole = (Path(place) / name for name in ("killed.yaml", "killed", "whole"))
        content = STUDY.format(
            points=given.runs // 2, duration=given.duration, physics=given.physics
        )
        file.write_text(content, encoding="utf-8")
        told = kill_in_the_middle(file, killed, given)
        began = time.monotonic()
        if begin(file, whole, max(1, given.workers // 2), "cores").wait(LONGEST) != 0:
            raise SystemExit("the undisturbed study failed")
        spent = time.monotonic() - began
        noted, calm = read_journals(killed / ROWS), read_journals(whole / ROWS)
        lost = sorted(set(calm.results) - set(noted.results))
        same = (killed / RESULTS).read_bytes() == (whole / RESULTS).read_bytes()
        outcome = {
            "runs": len(calm.results),
            "lost": len(lost),
            "finished runs repeated": len(noted.repeated),
            "same bytes": same,
            "undisturbed [s]": round(spent, 1),
        }
    print(*told, json.dumps(outcome), sep="\n")
    wrong = lost or noted.repeated or not same or len(calm.results) != given.runs
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
