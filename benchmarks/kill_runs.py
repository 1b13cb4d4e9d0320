"""`equipoise run` killed at random moments: what is left of it is whole, or says what is missing.

`python benchmarks/kill_runs.py --count 60 [--seed 0]`

A run is started as a process of its own and ended at a random time by SIGKILL, SIGTERM or Ctrl-C,
while it starts, simulates, measures or is about to end. What it leaves is then read: a folder
without a log is refused in a sentence; a log has all ticks up to the last that it has, without a
gap, equal to those of a run that was let go on, and says that it breaks off unless it is whole;
a summary is whole or not there. `latest` points to a run or to nothing. Anything else fails: a
traceback, a hang, numbers that differ, an end without a word. Ends with 1 if one failed.
"""

from __future__ import annotations

import argparse
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np

from equipoise.errors import EquipoiseError
from equipoise.runlog import Run, load_run

LONGEST = 120.0  # [s] a run may take in all before it counts as hanging
GRACE = 30.0  # [s] after a signal that can be answered
SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)
FAILURES = ("traceback", "hang", "gap", "wrong", "silent")
DURATION = 25.0  # [s] simulated, about as long as starting takes


def start(folder: Path) -> subprocess.Popen[str]:
    """Start a run into a folder as a process of its own."""
    command = [sys.executable, "-m", "equipoise.cli", "run", "press", "--no-figures"]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    return subprocess.Popen(
        [*command, "--out", str(folder), "--set", f"duration={DURATION}"],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env=environment,
        start_new_session=True,
    )


def kill_at(folder: Path, after: float, how: signal.Signals) -> tuple[str, str]:
    """Start a run and end it after so many seconds; return its output and "hang" if it hung."""
    process = start(folder)
    try:
        output, _ = process.communicate(timeout=after)
        return output, ""
    except subprocess.TimeoutExpired:
        process.send_signal(how)
    try:
        output, _ = process.communicate(timeout=GRACE)
        return output, ""
    except subprocess.TimeoutExpired:
        process.kill()
        output, _ = process.communicate()
        return output, "hang"


def judge(folder: Path, output: str, whole: Run) -> str:
    """Return what a killed run left."""
    if "Traceback" in output:
        print(output[-2000:])
        return "traceback"
    try:
        run = load_run(folder)
    except EquipoiseError as error:
        return "nothing yet" if str(error) else "silent"
    if run.t.size and not np.array_equal(run.t, whole.t[: run.t.size]):
        return "gap"
    if not all(np.array_equal(run[name], whole[name][: run.t.size]) for name in whole):
        return "wrong"
    if run.t.size < whole.t.size:
        if run.complete:  # Ctrl-C: the log was closed; the summary has to say so
            ended = (run.summary or {}).get("ended", "interrupted")
            return "closed early" if ended == "interrupted" else "silent"
        return "breaks off" if "breaks off" in run.note else "silent"
    if run.summary is None:
        return "without summary"
    return "whole"


def main(arguments: list[str] | None = None) -> int:
    """Kill runs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args(arguments)
    rng = np.random.default_rng(given.seed)
    outcomes: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as place:
        began = time.perf_counter()
        process = start(Path(place) / "whole")
        output, _ = process.communicate(timeout=10.0 * LONGEST)
        took = time.perf_counter() - began
        if not (Path(place) / "whole" / "summary.json").exists():
            print(output)
            return 1
        began = time.perf_counter()
        start(Path(place) / "again").communicate(timeout=LONGEST)  # kernels are there by now
        took = min(took, time.perf_counter() - began)
        whole = load_run(Path(place) / "whole")
        for k in range(given.count):
            folder = Path(place) / f"run{k}"
            how = SIGNALS[int(rng.integers(0, len(SIGNALS)))]
            after = float(rng.uniform(0.05, 1.05)) * took
            output, hung = kill_at(folder, after, how)
            outcome = hung or judge(folder, output, whole)
            outcomes[outcome] += 1
            if outcome in FAILURES:
                print(f"  seed {given.seed} number {k}: {how.name} after {after:.2f} s: {outcome}")
    print(f"{given.count} killed runs (one takes {took:.1f} s): {dict(outcomes)}")
    return 1 if any(outcomes[name] for name in FAILURES) else 0


if __name__ == "__main__":
    sys.exit(main())
