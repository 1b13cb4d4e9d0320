"""Sessions over a bad wire, drawn at random: who falls, what is said, what is beyond a limit.

    python benchmarks/wire_faults.py --sessions 200 --robot g1

Both ends are those that run on sockets; the network is virtual, with a time of its own, so that
the same seed gives the same sessions on any machine. Ends with 1 if any session broke a promise.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from dataclasses import asdict
from pathlib import Path

import numpy as np

from equipoise.remote.rehearsal import Outcome, Rehearsed, rehearse
from equipoise.scenarios import read_scenario
from equipoise.simulation.build.assemble import Prepared, starting_posture
from equipoise.simulation.build.setup import build_setup
from equipoise.wire.virtual import NetworkFaults

DURATION = 1.2  # [s] of each session


def drawn(random: np.random.Generator, seed: int) -> Rehearsed:
    """Return what is tried: faults of the network, a silence, a kill in two sessions of three."""
    begin, length = random.uniform(0.1, 1.0), random.uniform(0.001, 0.02)
    if random.random() < 0.25:
        length = random.uniform(0.02, 0.5)  # longer than the robot bears
    faults = NetworkFaults(
        loss=random.uniform(0.01, 0.3),
        double=random.uniform(0.0, 0.2),
        spoil=random.uniform(0.0, 0.1),
        garbage=random.uniform(0.0, 0.2),
        delay=(0.0, random.uniform(0.0, 0.005)),
        silences=((begin, begin + length),),
    )
    killed = ("", "loop", "robot")[int(random.integers(3))]
    return Rehearsed(faults, seed, killed, random.uniform(0.1, 1.1))  # type: ignore[arg-type]


def line_of(number: int, tried: Rehearsed, outcome: Outcome) -> str:
    """Return a session in a line."""
    (begin, end), delay = tried.faults.silences[0], tried.faults.delay[1]
    return (
        f"{number:4d} loss {tried.faults.loss:.2f} delay to {1e3 * delay:.1f} ms silence "
        f"{1e3 * (end - begin):5.1f} ms killed {tried.killed or '-':5s} "
        f"{'FELL' if outcome.fell else 'stands'}, share {outcome.share:.2f}, "
        f"{outcome.ticks} ticks: {outcome.ended}"
    )


def main() -> None:
    """Run the sessions, print a line each and a summary."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sessions", type=int, default=200)
    parser.add_argument("--first", type=int, default=0, help="number of the first session")
    parser.add_argument("--robot", default="g1")
    parser.add_argument("--scenario", default="press")
    parser.add_argument("--physics", default="mujoco")
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    changes = [f"duration={DURATION}", f"physics.engine={given.physics}"]
    scenario = read_scenario(given.scenario, changes, robot=given.robot)
    setup = build_setup(scenario)
    prepared = Prepared(setup.robot, starting_posture(scenario, setup))
    rows, counts = [], Counter[str]()
    for number in range(given.first, given.first + given.sessions):
        tried = drawn(np.random.default_rng(number), number)
        outcome = rehearse(scenario, prepared, tried, lockstep=False)
        print(line_of(number, tried, outcome), flush=True)
        rows.append({"number": number, **asdict(tried), **asdict(outcome), "fell": outcome.fell})
        counts["fell"] += outcome.fell
        counts["told a torque beyond its limit"] += not outcome.share <= 1.0
        counts["ran to the end"] += outcome.ended == "completed"
    print(f"{len(rows)} sessions: " + ", ".join(f"{n} {what}" for what, n in counts.items()))
    if given.json is not None:
        given.json.write_text(json.dumps(rows, indent=1))
    sys.exit(bool(counts["fell"] or counts["told a torque beyond its limit"]))


if __name__ == "__main__":
    main()
