"""Walks under everything that a walk must bear: one line of JSON a run, and the tables of the docs.

`python benchmarks/walking.py [--robot hrp2] [--case plank] [--set walk.balance=null] [--out FILE]`

Without choices it runs every case on HRP-2, TALOS and G1 (about half an hour of one core) and
writes `benchmarks/walking.jsonl`; `python docs/walking_tables.py` fills docs/walking.md from it.
Every case is a scenario as shipped with the overrides written in the line, run by the classes of
`equipoise run`. Base and joints are the largest difference to the reference of the tick.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from equipoise.errors import ScenarioError
from equipoise.robots import Robot, get_robot
from equipoise.scenarios import read_scenario
from equipoise.simulation.simulation import Simulation
from equipoise.studies.in_memory import COMPLETED, Ticks, run_in_memory

OUT = Path(__file__).with_name("walking.jsonl")
ROBOTS = ("hrp2", "talos", "g1")
METRICS = ("base_error", "posture_error", "switch_jump", "walk_steps", "reaction_pressure",
           "clamped_longest", "torque_share", "velocity_share", "joint_margin")  # fmt: skip
FALLEN = 0.2  # [m] lower than it was wanted
BACK = (0.002, 0.03, 0.005)  # [m] base, [rad] joints, [m] reference off its plan: walks as before
Overrides = Callable[[Robot], list[str]]


@dataclass(frozen=True)
class Case:
    """A scenario with overrides; `pushed` [s] is when a push ends."""

    scenario: str
    overrides: Overrides | Sequence[str] = ()
    robots: Sequence[str] = ROBOTS
    engine: str = "mujoco"
    pushed: float | None = None

    def read(self, robot: str, more: Sequence[str] = ()) -> list[str]:
        """Return the overrides for a robot."""
        own = self.overrides
        given = list(own(get_robot(robot)) if callable(own) else own)
        return [f"physics.engine={self.engine}", *given, *more]


def push(force: str, start: float) -> Overrides:
    """Push the chest for 0.2 s."""

    def overrides(robot: Robot) -> list[str]:
        chest = robot.parts["torso"][-1]
        one = f"{{frame: {chest}, force: {force}, start: {start}, duration: 0.2}}"
        return [f"faults.pushes=[{one}]"]

    return overrides


def load(mass: float) -> list[str]:
    """Return a mass [kg] in the right hand that nobody told."""
    return [f"disturbances.payloads=[{{frame: right_palm, mass: {mass}}}]"]


def plank(height: float) -> Overrides:
    """A plank that nobody told under the second step (left foot), 12 cm longer than the foot.

    A foot goes on by two strides, so that the next step of it is behind the plank.
    """

    def overrides(robot: Robot) -> list[str]:
        walk = read_scenario("walk", robot=robot.name).walk
        assert walk is not None
        assert walk.along is not None
        sole = robot.soles[0]
        at = robot.at(robot.q_half_sitting).placement(sole.frame).translation
        x = 2.0 * walk.along.forward + 0.5 * (sole.x_min + sole.x_max)
        y = float(at[1]) + 0.5 * (sole.y_min + sole.y_max)
        size = [sole.x_max - sole.x_min + 0.12, sole.y_max - sole.y_min + 0.04, height]
        shape = f"{{box: {[round(one, 4) for one in size]}}}"
        place = f"{{xyz: [{x:.4f}, {y:.4f}, {0.5 * height}]}}"
        steps = ["walk.along.count=5", "duration=9.2"]
        return [*steps, f"world.bodies={{plank: {{at: {place}, shapes: [{shape}]}}}}"]

    return overrides


def stairs(robot: Robot) -> list[str]:
    """Four stairs of 5 cm, 4 cm deeper than a sole; the last step puts the feet side by side."""
    sole, bodies = robot.soles[0], []
    deep = round(sole.x_max - sole.x_min + 0.04, 3)
    for k in range(1, 5):
        # a stair begins behind the heel of the foot that is put on it, and goes on to the last
        begin = k * deep + sole.x_min - 0.02
        end = 4 * deep + sole.x_max + 0.1
        size = [round(end - begin, 4), 1.0, RISE]
        at = f"{{xyz: [{0.5 * (begin + end):.4f}, 0.0, {(k - 0.5) * RISE:.4f}]}}"
        bodies.append(f"stair_{k}: {{at: {at}, shapes: [{{box: {size}}}]}}")
    return [
        f"walk.along={{count: 5, forward: {deep}, up: {RISE}}}", "walk.crouch=0.08",
        "walk.swing.height=0.05", "walk.timing={single: 1.4, double: 0.8}", "duration=15",
        f"world.bodies={{{', '.join(bodies)}}}",
    ]  # fmt: skip


RISE = 0.05  # [m] height of a stair
SIDE = ["walk.along={count: 4, left: 0.02}"]
TURNING = ["walk.along={count: 6, forward: 0.1, turn: 0.1}", "duration=10.5"]
TWELVE = ["walk.along.count=12", "duration=17.5"]
FAST = ["walk.timing={single: 0.4, double: 0.15}", "walk.swing.height=0.03", "duration=6"]
STEERED_FAST = [
    *FAST[:2],
    "duration=11",
    "walk.steer=[{at: 0.1, forward: 0.3}, "
    "{at: 4.0, forward: 0.15, turn: 0.15}, {at: 6.0, left: -0.02}, {at: 8.0}]",
]
NOISE = ["sensors.force.noise=2.0", "sensors.joint_velocity.noise=0.05"]


def cases() -> dict[str, Case]:
    """Return every case by name."""
    found: dict[str, Case] = {}
    for engine in ("mujoco", "rigid"):
        end = "" if engine == "mujoco" else ", rigid"
        found |= {
            f"walk{end}": Case("walk", engine=engine),
            f"slow steps{end}": Case("slow_steps", engine=engine),
            f"12 steps{end}": Case("walk", TWELVE, engine=engine),
            f"0.4/0.15 s{end}": Case("walk", FAST, engine=engine),
        }
    found |= {
        "steered": Case("steered_walk"),
        "steered, rigid": Case("steered_walk", engine="rigid"),
        "steered, 0.4/0.15 s": Case("steered_walk", STEERED_FAST),
        "side steps": Case("walk", SIDE),
        "turning": Case("walk", TURNING),
        "stairs": Case("walk", stairs),
        "stairs, rigid": Case("walk", stairs, engine="rigid"),
        "side steps, rigid": Case("walk", SIDE, engine="rigid"),
        "turning, rigid": Case("walk", TURNING, engine="rigid"),
        "masses x 1.3": Case("walk", ["disturbances.mass_scale=1.3"]),
        "masses x 0.7": Case("walk", ["disturbances.mass_scale=0.7"]),
        "friction 0.4": Case("walk", ["physics.mujoco.sole_friction=0.4"]),
        "delay 3 ms": Case("walk", ["faults.measurement_delay=0.003"]),
        "delay 5 ms": Case("walk", ["faults.measurement_delay=0.005"]),
        "noise": Case("walk", NOISE),
        "1 kg in a hand": Case("walk", load(1.0), robots=["g1"]),
        "2 kg in a hand": Case("walk", load(2.0), robots=["g1"]),
        "5 kg in a hand": Case("walk", load(5.0)),
        "plank 1 cm": Case("walk", plank(0.01)),
        "plank 2 cm": Case("walk", plank(0.02)),
        "push 60 N forward": Case("walk", push("[60, 0, 0]", 1.8), pushed=2.0),
        "push 60 N forward, both feet": Case("walk", push("[60, 0, 0]", 2.4), pushed=2.6),
        "push 30 N to the left": Case("walk", push("[0, 30, 0]", 1.8), pushed=2.0),
        "push 30 N to the right": Case("walk", push("[0, -30, 0]", 1.8), pushed=2.0),
        "push 30 N to the left, both feet": Case("walk", push("[0, 30, 0]", 2.4), pushed=2.6),
    }
    return found


@dataclass
class Result:
    """A run in numbers: lengths in mm, angles in mrad, times in s."""

    case: str
    robot: str
    ended: str
    base: float
    joints: float
    jump: float
    steps: int
    cop: float | None = None
    back: float | None = None
    more: dict[str, float] = field(default_factory=dict)

    @property
    def walks(self) -> bool:
        """Whether it stood to the end."""
        return self.ended == COMPLETED


def judged(name: str, robot: str, case: Case, ticks: Ticks) -> Result:
    """Return what a run showed."""
    found, run = ticks.metrics(METRICS), ticks.run
    ended, fallen = ticks.ended, fell(ticks)
    if fallen is not None:
        ended = f"fell at {fallen:.2f} s"
    result = Result(
        name, robot, ended, 1e3 * found["base_error"], 1e3 * found["posture_error"],
        found.get("switch_jump", 0.0), int(found["walk_steps"]),
    )  # fmt: skip
    if "reaction_pressure" in found:
        result.cop = 1e3 * found["reaction_pressure"]
    if case.pushed is not None and fallen is None:
        result.back = back_after(run, case.pushed)
    for key in ("clamped_longest", "torque_share", "velocity_share", "joint_margin"):
        result.more[key] = found[key]
    return result


def fell(ticks: Ticks) -> float | None:
    """Return when the base is lower than wanted by more than a fall allows, None if never."""
    run = ticks.run
    low = np.flatnonzero(run["q_ref"][:, 2] - run["q"][:, 2] > FALLEN)
    if low.size:
        return float(run.t[low[0]])
    return None if ticks.ended == COMPLETED else float(run.t[-1])


def back_after(run: Any, t: float) -> float:
    """Return how long [s] after `t` the walk is as before."""
    base = np.linalg.norm(run["dq"][:, :3], axis=1)
    joints = np.abs(run["dq"][:, 6:]).max(axis=1)
    off = (base > BACK[0]) | (joints > BACK[1])
    if "walk/aside" in run:
        off |= np.linalg.norm(run["walk/aside"][:, :2], axis=1) > BACK[2]
    late = np.flatnonzero(off & (run.t > t))
    return float(run.t[late[-1]] - t) if late.size else 0.0


def measure(name: str, robot: str, more: Sequence[str] = ()) -> tuple[Result, Ticks]:
    """Run a case on a robot."""
    case = cases()[name]
    scenario = read_scenario(case.scenario, case.read(robot, more), robot=robot)
    ticks = run_in_memory(Simulation(scenario), stop_when_off=True)
    return judged(name, robot, case, ticks), ticks


def told(one: Result) -> str:
    """Return a result in a line for people."""
    extra = [f"{key} {value:.3g}" for key, value in one.more.items()]
    cop = "-" if one.cop is None else f"{one.cop:.1f}"
    back = "" if one.back is None else f", back after {one.back:.2f} s"
    return (
        f"{one.case:34} {one.robot:6} {one.ended:16} base {one.base:7.2f} mm, joints "
        f"{one.joints:6.1f} mrad, jump {one.jump:.1e} N m, {one.steps} steps, cop {cop} mm{back}"
        f"  [{', '.join(extra)}]"
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Run what was chosen, and keep it."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--robot", action="append", choices=ROBOTS)
    parser.add_argument("--case", action="append", choices=list(cases()))
    parser.add_argument("--set", action="append", default=[], help="further overrides")
    parser.add_argument("--out", type=Path, help=f"results are added here (default {OUT.name})")
    parser.add_argument("--story", action="store_true", help="tell what happened to the feet")
    given = parser.parse_args(arguments)
    out = given.out or (None if given.set else OUT)
    for name in given.case or cases():
        for robot in given.robot or ROBOTS:
            if robot not in cases()[name].robots:
                continue
            try:
                result, ticks = measure(name, robot, given.set)
            except ScenarioError as refused:
                print(f"{name:34} {robot:6} refused: {refused}", flush=True)
                continue
            print(told(result), flush=True)
            if given.story:
                print("\n".join(ticks.simulation.story))
            if out is not None:
                keep(out, result)
    return 0


def keep(path: Path, result: Result) -> None:
    """Write a result in place of the one before, if there was one."""
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    known = {(row["case"], row["robot"]): row for row in map(json.loads, lines)}
    known[result.case, result.robot] = rounded(vars(result))
    order = {name: k for k, name in enumerate(cases())}
    rows = sorted(known.values(), key=lambda row: (order.get(row["case"], 99), row["robot"]))
    path.write_text("".join(json.dumps(row) + "\n" for row in rows), encoding="utf-8")


def rounded(value: Any) -> Any:
    """Return numbers to four figures."""
    if isinstance(value, dict):
        return {key: rounded(one) for key, one in value.items()}
    return float(f"{value:.4g}") if isinstance(value, float) else value


if __name__ == "__main__":
    sys.exit(main())
