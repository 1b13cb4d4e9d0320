"""Safe means safe: a fault at a random time of a run, then two seconds and a half that are judged.

`python benchmarks/sweep_safe.py [--count 24] [--seed 0] [--robots hrp2 g1] [--engines mujoco]`

Cases are drawn from robots x engines x scenarios x faults x delays x periods x times; `--count 0`
runs every combination once. A case is well if the robot still stands 2 s after the fault, or its
base is then lower than a quarter of its height; the base never comes down faster than 0.5 m/s, no
joint is faster than twice its limit, and no number is lost. Of an arm that is fixed to the world
the joints alone are judged. What the law did before it was switched off is not judged, and joints
that were racing by then are given 0.1 s to be braked. Prints every
case that is not well with what was worst, a table at the end, and ends with 1 if there was one.
"""

from __future__ import annotations

import argparse
import itertools
import logging
import random
import sys
import warnings
from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from equipoise.control import Mode
from equipoise.physics import DivergedError
from equipoise.scenarios import read_scenario
from equipoise.simulation.build.assemble import Prepared
from equipoise.simulation.simulation import Simulation

ROBOTS = ("hrp2", "talos", "g1", "romeo", "panda")
ENGINES = ("rigid", "mujoco")
SCENARIOS = ("press", "tray")
FAULTS = ("base", "joints", "joint", "velocity", "nan", "stale", "stop", "none")
DELAYS = (0.0, 0.005)  # [s]
PERIODS = (0.001, 0.002, 0.005)  # [s]
EARLIEST, LATEST = 0.2, 1.5  # [s] of a fault
JUDGED = 2.0  # [s] after the law was switched off
LOOKED_ON = 0.5  # [s] more
STANDS, LIES = 0.9, 0.25  # share of the base's height
SINKS = 0.5  # [m/s] of the base downwards
RACES = 2.0  # times a joint's speed limit
BRAKED = 0.1  # [s] after the law was switched off, from when on that is judged


@dataclass(frozen=True)
class Case:
    """A robot in a scenario and an engine; what is lost at `at` [s]; the loop's delay and period.

    Faults: `base`, all `joints`, one `joint`, joint `velocity`, a `nan` in the reference for good;
    a `stale` state that repeats itself; an emergency `stop`; `none` but the delay.
    """

    robot: str
    engine: str
    scenario: str
    fault: str
    delay: float
    period: float
    at: float

    def overrides(self, joint: str) -> list[str]:
        """Return what is set in the scenario; `joint` is the one that is lost."""
        late = round(0.6 * self.delay, 4)
        given = [
            f"physics.engine={self.engine}",
            f"control.period={self.period}",
            f"duration={self.at + JUDGED + LOOKED_ON}",
            f"faults.measurement_delay={late}",
            f"faults.command_delay={round(self.delay - late, 4)}",
        ]
        reading = "frozen" if self.fault == "stale" else "nan"
        lost = {
            "base": ["base"],
            "joints": ["joint_position", "joint_velocity"],
            "joint": [joint],
            "velocity": ["joint_velocity"],
            "stale": ["base", "joint_position", "joint_velocity"],
        }.get(self.fault, [])
        silences = ", ".join(
            f"{{sensor: {sensor}, start: {self.at}, reading: {reading}}}" for sensor in lost
        )
        return [*given, f"faults.silences=[{silences}]"]

    def __str__(self) -> str:
        late, period = 1e3 * self.delay, 1e3 * self.period
        return (
            f"{self.robot:6}{self.engine:7}{self.scenario:10}{self.fault:9}at {self.at:.2f} s, "
            f"{late:.0f} ms late, every {period:.0f} ms"
        )


@dataclass(frozen=True)
class Outcome:
    """How a case ended: what was wrong (nothing if empty), and its figures since SAFE.

    `off` [s] when the law was switched off, NaN if never; `height` as a share 2 s later, `falls`
    [m/s] the fastest way down, `races` the largest share of a joint's speed limit.
    """

    wrong: tuple[str, ...]
    off: float
    height: float
    falls: float
    races: float
    story: tuple[str, ...]


class Sweep:
    """Runs cases; what runs of one robot in one scenario share is found once."""

    def __init__(self, extra: Sequence[str] = ()) -> None:
        self._extra = list(extra)
        self._prepared: dict[tuple[str, str], Prepared] = {}

    def made(self, case: Case) -> Simulation:
        """Return the simulation of a case."""
        own = {"press": "hrp2", "tray": "hrp2"}.get(case.scenario)
        key = case.scenario, case.robot
        joint = ""
        if key in self._prepared:
            joint = _a_joint(self._prepared[key], case)
        else:
            first = replace(case, fault="none", period=0.001)
            made = Simulation(self._read(first, "", own))
            assembly = made.assembly
            self._prepared[key] = Prepared(made.robot, assembly.q_start, assembly.outlook)
            joint = _a_joint(self._prepared[key], case)
        return Simulation(self._read(case, joint, own), self._prepared[key])

    def _read(self, case: Case, joint: str, own: str | None):
        given = [*case.overrides(joint), *self._extra]
        return read_scenario(case.scenario, given, robot=None if case.robot == own else case.robot)

    def run(self, case: Case) -> Outcome:
        """Run a case; return how it ended."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            simulation = self.made(case)
            return judged(simulation, case)


def _a_joint(prepared: Prepared, case: Case) -> str:
    names = prepared.robot.joint_names
    return names[random.Random(repr(case)).randrange(len(names))]


def judged(simulation: Simulation, case: Case) -> Outcome:
    """Run a simulation to its end and judge what happened since the law was switched off."""
    robot, supervisor = simulation.robot, simulation.controller.supervisor
    base, kept, wrong = robot.nv_base, [], []
    off = np.nan
    q_0 = simulation.engine.state.q.copy()
    try:
        for t, record in simulation.ticks():
            if t >= case.at:
                _break(simulation, case, t)
            q, v = record["q"], record["v"]
            share = np.abs(v[base:]) / robot.v_max
            kept.append((t, q[2] if base else 1.0, share.max(), int(share.argmax())))
            if np.isnan(off) and supervisor.mode in (Mode.SAFE, Mode.STOPPED):
                off = t
    except DivergedError as error:
        wrong.append(str(error).splitlines()[0])
    told = tuple(str(change) for change in supervisor.changes)
    seen = np.array(kept)
    height = q_0[2] if base else 1.0
    if np.isnan(off):
        if case.fault not in ("none", "stale"):
            wrong.append("the law was never switched off")
        since = seen[seen[:, 0] >= case.at]
        off = case.at
    else:
        since = seen[seen[:, 0] >= off]
    if len(since) < 3:
        return Outcome((*wrong, "nothing to judge"), off, np.nan, np.nan, np.nan, told)
    falls = float(-np.diff(since[:, 1]).min() / case.period)
    worst = int(np.where(since[:, 0] >= off + BRAKED, since[:, 2], 0.0).argmax())
    after = since[since[:, 0] >= off + JUDGED]
    end = float(after[0, 1] / height) if len(after) else np.nan
    if base:
        if falls > SINKS:
            wrong.append(f"the base falls at {falls:.2f} m/s")
        if LIES <= end < STANDS:
            wrong.append(f"after 2 s the base is at {100 * end:.0f} %")
    if since[worst, 2] > RACES:
        name = robot.joint_names[int(since[worst, 3])]
        wrong.append(
            f"{name} races at {since[worst, 2]:.1f} of its limit, "
            f"{since[worst, 0] - off:.3f} s after"
        )
    return Outcome(tuple(wrong), off, end, falls, float(since[worst, 2]), told)


def _break(simulation: Simulation, case: Case, t: float) -> None:
    """Do at time `t` [s] what no sensor does."""
    controller = simulation.controller
    if case.fault == "stop":
        controller.supervisor.give_up(t, "emergency stop")
    elif case.fault == "nan":
        controller.workspace.parts["reference"].q[-1] = np.nan


def cases(given: argparse.Namespace) -> list[Case]:
    """Return the cases that were asked for, in an order that shares preparations."""
    rng = random.Random(given.seed)
    every = []
    for robot, engine, scenario, fault, delay, period in itertools.product(
        given.robots, given.engines, given.scenarios, given.faults, given.delays, given.periods
    ):
        arm = robot == "panda"
        if arm and (engine == "mujoco" or fault == "base" or scenario != given.scenarios[0]):
            continue  # one scenario is enough for an arm, and nothing of its base can be lost
        if fault == "none" and delay == 0.0:
            continue
        at = rng.uniform(EARLIEST, LATEST) if given.at is None else given.at
        case = Case(robot, engine, scenario, fault, delay, period, round(at, 2))
        every.append(replace(case, scenario="arm_press") if arm else case)
    chosen = every if given.count == 0 else rng.sample(every, min(given.count, len(every)))
    return sorted(chosen, key=lambda case: (case.scenario, case.robot, case.engine))


def table(rows: Iterable[tuple[Case, Outcome]]) -> str:
    """Return how many are well, stand, lie, by robot and engine and by fault."""
    lines, by = [], defaultdict(Counter)
    for case, outcome in rows:
        stands = outcome.height >= STANDS
        late, period = 1e3 * case.delay, 1e3 * case.period
        told = f"{late:.0f} ms late", f"every {period:.0f} ms"
        for key in (f"{case.robot} {case.engine}", f"fault {case.fault}", *told):
            by[key]["cases"] += 1
            by[key]["well"] += not outcome.wrong
            by[key]["stand"] += stands and not outcome.wrong
            by[key]["lie"] += outcome.height < LIES and not outcome.wrong
    lines.append(f"| {'':18} | cases | well | stand | lie |")
    lines.append("|---|---|---|---|---|")
    for key, count in by.items():
        numbers = " | ".join(str(count[name]) for name in ("cases", "well", "stand", "lie"))
        lines.append(f"| {key:18} | {numbers} |")
    return "\n".join(lines)


def main() -> int:
    """Run the sweep that the command line asks for; return 1 if a case was not well."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robots", nargs="+", default=ROBOTS)
    parser.add_argument("--engines", nargs="+", default=ENGINES, choices=ENGINES)
    parser.add_argument("--scenarios", nargs="+", default=SCENARIOS)
    parser.add_argument("--faults", nargs="+", default=FAULTS, choices=FAULTS)
    parser.add_argument("--delays", nargs="+", type=float, default=DELAYS, help="[s]")
    parser.add_argument("--periods", nargs="+", type=float, default=PERIODS, help="[s]")
    parser.add_argument("--at", type=float, help="[s] of the fault, instead of a random time")
    parser.add_argument("--count", type=int, default=24, help="cases; 0: all")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--set", action="append", default=[], dest="extra")
    parser.add_argument("--all", action="store_true", help="print those that are well too")
    given = parser.parse_args()
    logging.disable(logging.WARNING)
    chosen, sweep, rows = cases(given), Sweep(given.extra), []
    for k, case in enumerate(chosen):
        outcome = sweep.run(case)
        rows.append((case, outcome))
        if outcome.wrong or given.all:
            print(
                f"{k + 1:4}/{len(chosen)} {case}: {'; '.join(outcome.wrong) or 'well'} "
                f"({100 * outcome.height:.0f} %, {outcome.falls:.2f} m/s, {outcome.races:.2f} of a "
                f"limit)",
                flush=True,
            )
            for change in outcome.story:
                print(f"          {change}", flush=True)
        elif k % 10 == 9:
            print(f"{k + 1:4}/{len(chosen)}", flush=True)
    bad = sum(bool(outcome.wrong) for _, outcome in rows)
    print(table(rows))
    print(f"{len(rows) - bad} of {len(rows)} well")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
