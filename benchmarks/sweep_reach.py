"""Hands sent where they cannot get: the arm stretches and waits, the robot stands, nothing else.

`python benchmarks/sweep_reach.py [--robots hrp2 talos] [--engines rigid mujoco] [--seed 0]`

Each case sends the right hand of a robot, in a second, to a place that lies 0.1 to 1 m beyond its
arm in one of five directions, leaves it there, and runs 8 s. A case is well if nothing impossible
happened, the law was never switched off, the robot stands, the reference has come to rest, and it
was told before the run. The verdict has to be "not met" all the same where the hand did not get
there. Ends with 1 if a case is not well.
"""

from __future__ import annotations

import argparse
import logging
import random
import sys
import tempfile
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import pinocchio as pin

from equipoise.api import run_scenario
from equipoise.robots import get_robot
from equipoise.runlog import Run

ROBOTS = ("hrp2", "talos", "g1", "romeo")
DIRECTIONS = {
    "forward": (1.0, 0.0, 0.0),
    "aside": (0.0, -1.0, 0.0),
    "up": (0.0, 0.0, 1.0),
    "behind": (-1.0, 0.0, 0.0),
    "low": (0.6, 0.0, -0.8),
}
AS_FAR = "as far as it could"  # said of a hand that did not get to where it was sent
DURATION, WATCHED = 8.0, 1.0  # [s] of a run, and of its end that is looked at
AT_REST = 0.15  # [rad/s] of every joint of the reference by then
STANDING = 0.9  # of the height at the start
SHORT = 0.02  # [m] beyond which the hand did not get to where it was sent
TOLD = "cannot reach its waypoint", " s instead of "  # of a waypoint, or of a way that is slowed

SCENARIO = """
name: beyond_reach
title: A hand is sent where it cannot get
robot: {robot}
duration: {duration}
physics: {{engine: {engine}}}
contacts: {contacts}
tasks:
  {com}
  limits: {{kind: joint_limits, priority: 1}}
  hand:
    kind: frame_path
    frame: right_palm
    priority: 2
    waypoints:
      - {{t: 0.2, xyz: [{start}], rpy: [{rpy}]}}
      - {{t: 1.2, xyz: [{target}], rpy: [{rpy}]}}
  posture: {{kind: posture, rate: 2.0, priority: 3}}
control: {{start: standing}}
"""
SOLES = "{left_sole: {kind: sole, sole: left_sole}, right_sole: {kind: sole, sole: right_sole}}"
COM = "com: {kind: com_polygon, margin: 0.03, priority: 1}"


@dataclass(frozen=True)
class Case:
    """A hand of a robot in an engine, sent in a direction, `beyond` [m] of its reach."""

    robot: str
    engine: str
    direction: str
    beyond: float

    def text(self) -> str:
        """Return the scenario."""
        robot = get_robot(self.robot)
        kin = robot.at(robot.q_half_sitting)
        palm = kin.placement("right_palm")
        shoulder, length = arm_of(robot, kin)
        way = np.array(DIRECTIONS[self.direction])
        target = shoulder + (length + self.beyond) * way / np.linalg.norm(way)
        stands = robot.nv_base == 6
        return SCENARIO.format(
            robot=self.robot,
            duration=DURATION,
            engine=self.engine,
            contacts=SOLES if stands else "{}",
            com=COM if stands else "",
            start=_listed(palm.translation),
            rpy=_listed(pin.rpy.matrixToRpy(palm.rotation)),
            target=_listed(target),
        )


def _listed(numbers: np.ndarray) -> str:
    return ", ".join(f"{number:.4f}" for number in numbers)


def arm_of(robot, kin) -> tuple[np.ndarray, float]:
    """Return where the first joint of the right arm is, and the sum of the arm's links [m].

    The arm begins where the joints that carry the right palm part from those that carry the left.
    """
    model = robot.model
    left, right = (
        list(model.supports[model.frames[robot.frame_id(f"{side}_palm")].parentJoint])
        for side in ("left", "right")
    )
    joints = [joint for joint in right if joint not in left]
    places = [kin.joint_placement(joint).translation for joint in joints]
    places.append(kin.placement("right_palm").translation)
    return places[0], float(sum(np.linalg.norm(b - a) for a, b in pairwise(places)))


@dataclass(frozen=True)
class Outcome:
    """How a case ended: what was wrong (nothing if empty), and its figures."""

    wrong: tuple[str, ...]
    fastest: float  # [rad/s] of the reference at the end
    miss: float  # [m] of the hand at the end
    height: float  # least share of the base's height
    peak: float  # [rad/s^2] largest acceleration of a joint of the reference


def outcome_of(run: Run, stands: bool) -> Outcome:
    """Return what is wrong with a finished run, if anything is."""
    summary = run.summary
    period = float(np.median(np.diff(run.t)))
    v = run["v_ref"][:, -run["tau"].shape[1] :]
    last = run.t >= run.t[-1] - WATCHED
    fastest = float(np.abs(v[last]).max())
    peak = float(np.abs(np.diff(v, axis=0)).max() / period)
    height = float((run["q"][:, 2] / run["q"][0, 2]).min()) if stands else 1.0
    miss = float(np.linalg.norm(run["error/hand"][-1, :3]))
    wrong = [one for one in summary["impossible"] if AS_FAR not in one]
    if height < STANDING:
        wrong.append(f"the base sank to {100 * height:.0f} % of its height")
    if fastest > AT_REST:
        wrong.append(f"the reference still moves, by {fastest:.2f} rad/s")
    if not any(TOLD[0] in one or TOLD[1] in one for one in summary["changes"]):
        wrong.append("nobody was told")
    if miss > SHORT and not any(AS_FAR in one for one in summary["impossible"]):
        wrong.append("the verdict does not say that the hand did not get there")
    return Outcome(tuple(wrong), fastest, miss, height, peak)


def run_case(case: Case, folder: Path, extra: Sequence[str] = ()) -> Outcome:
    """Run a case into a folder, with overrides; return how it ended."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        path = folder / "beyond_reach.yaml"
        path.write_text(case.text(), encoding="utf-8")
        run = run_scenario(str(path), out=folder / "run", overrides=extra, figures=False)
    return outcome_of(run, "left_sole" in case.text())


def cases(robots: Sequence[str], engines: Sequence[str], seed: int, count: int) -> list[Case]:
    """Return the cases of a seed: every direction `count` times, by a random distance."""
    rng, found = random.Random(seed), []
    for robot in robots:
        for engine in engines:
            for direction in DIRECTIONS:
                for _ in range(count):
                    beyond = round(rng.uniform(0.1, 1.0), 2)
                    found.append(Case(robot, engine, direction, beyond))
    return found


def main() -> int:
    """Run the sweep that the command line asks for; return 1 if a case was not well."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robots", nargs="+", default=ROBOTS)
    parser.add_argument("--engines", nargs="+", default=("rigid", "mujoco"))
    parser.add_argument("--directions", nargs="+", default=tuple(DIRECTIONS))
    parser.add_argument("--count", type=int, default=1, help="cases a direction")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--set", action="append", default=[], dest="extra")
    given = parser.parse_args()
    logging.disable(logging.WARNING)
    bad = total = 0
    for case in cases(given.robots, given.engines, given.seed, given.count):
        if case.direction not in given.directions:
            continue
        with tempfile.TemporaryDirectory() as folder:
            found = run_case(case, Path(folder), given.extra)
        total += 1
        bad += bool(found.wrong)
        print(
            f"{case.robot:6} {case.engine:6} {case.direction:8} +{case.beyond:.2f} m  "
            f"{'well' if not found.wrong else 'WRONG'}  misses {found.miss:.3f} m, reference "
            f"{found.fastest:.3f} rad/s, at most {found.peak:.0f} rad/s^2, "
            f"base {100 * found.height:.0f} %  {'; '.join(found.wrong)}",
            flush=True,
        )
    print(f"{total - bad} of {total} well")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
