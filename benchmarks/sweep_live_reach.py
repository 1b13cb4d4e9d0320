"""Live targets sent where a hand cannot get, as a user sends them: it stretches, waits, comes.

`python benchmarks/sweep_live_reach.py [--robots hrp2 g1] [--engines rigid] [--how jump drag]`

A robot stands on its soles, or is bolted down, with one hand that is given as a pose. At 0.2 s the
target is sent beyond the arm, by a jump or dragged at 0.25 m/s; at 6 s it is called back the same
way; at 18 s it ends. A case is well if the law was never switched off, the robot stands, reference
and robot are at rest at the end of the wait, and the hand is back in the end. Nothing but the
target is said: what the robot does is what it does by default. Ends with 1 if a case is not well.
"""

from __future__ import annotations

import argparse
import logging
import random
import sys
import warnings
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from equipoise import LoopSettings, RigidContactEngine, WholeBodyController, get_robot
from equipoise.control.supervisor import Mode
from equipoise.robots.measures import measure
from equipoise.tasks import FramePoseTask

ROBOTS = ("hrp2", "talos", "g1", "romeo", "panda", "ur5")
DIRECTIONS = {
    "forward": (1.0, 0.0, 0.0),
    "up": (0.0, 0.0, 1.0),
    "aside": (0.0, -1.0, 0.0),
    "behind": (-1.0, 0.0, 0.0),
}
AWAY, BACK, END = 0.2, 6.0, 18.0  # [s] when the target is sent, called back, and all is over
DRAG, SOFTLY = 0.25, 0.5  # [m/s], [s] in which it comes to that
STANDING = 0.9  # of the height at the start
AT_REST = 0.3  # [rad/s] of every joint, of the reference and of the robot
HOME = 1e-3  # [m] from where the hand was, in the end, by the reference
ROTORS = 0.05  # [kg m^2] in MuJoCo; and in the rigid engine with --rotors


@dataclass(frozen=True)
class Case:
    """A hand of a robot in an engine, sent in a direction, `beyond` [m] its reach, in one way."""

    robot: str
    engine: str
    direction: str
    beyond: float
    how: str
    period: float = 0.001
    rotors: bool = False
    margin: float | None = None


@dataclass(frozen=True)
class Outcome:
    """How a case ended: what was wrong (nothing if empty), and its figures."""

    wrong: tuple[str, ...]
    stretched: float  # [m] that the hand got on its way
    peak: float  # [rad/s^2] largest acceleration of a joint of the reference
    fastest: float  # [rad/s] largest speed of a joint of the robot
    waiting: float  # [rad/s] of the reference in the last second of the wait
    torque: float  # largest share of a torque limit, in that second
    back: float  # [m] of the reference in the end

    def __str__(self) -> str:
        return (
            f"went {self.stretched:.2f} m, {self.peak:.0f} rad/s^2, {self.fastest:.1f} rad/s, "
            f"waiting {self.waiting:.3f} rad/s at {100 * self.torque:.0f} % torque, "
            f"back to {1e3 * self.back:.1f} mm  {'; '.join(self.wrong)}"
        )


def target_of(case: Case) -> tuple[pin.SE3, pin.SE3]:
    """Return where the hand begins, and where it is sent."""
    robot = get_robot(case.robot)
    home = robot.at(robot.q_half_sitting).placement(robot.palms[-1].frame).copy()
    sizes = measure(robot)
    shoulder = sizes.p_world_shoulders.copy()
    if robot.nv_base:  # the right one
        shoulder[1] = home.translation[1]
    way = sizes.reach + case.beyond
    return home, pin.SE3(home.rotation, shoulder + way * np.array(DIRECTIONS[case.direction]))


def _dragged(t: float) -> float:
    """Return how far [m] it is dragged in a time [s]."""
    t = max(t, 0.0)
    return DRAG * (t - 0.5 * SOFTLY if t > SOFTLY else 0.5 * t * t / SOFTLY)


def where(t: float, home: pin.SE3, far: pin.SE3, how: str) -> pin.SE3:
    """Return where the target is at time `t` [s]."""
    if how == "jump":
        return far if AWAY <= t < BACK else home
    way = np.linalg.norm(far.translation - home.translation)
    gone = min(_dragged(t - AWAY), way)
    if t >= BACK:
        gone = max(min(_dragged(BACK - AWAY), way) - _dragged(t - BACK), 0.0)
    p = home.translation + gone / way * (far.translation - home.translation)
    return pin.SE3(home.rotation, p)


def simulated(case: Case, controller):
    """Return the simulated robot of a case."""
    robot = controller.robot
    if case.engine == "mujoco":
        from equipoise.physics.mujoco.engine import MujocoEngine

        return MujocoEngine(robot, controller.contacts, robot.q_half_sitting, controller.dt)
    if case.rotors:
        model = robot.model.copy()
        armature = np.array(model.armature)
        armature[robot.nv_base :] += ROTORS
        model.armature = armature
        robot = replace(robot, model=model)
    return RigidContactEngine(robot, controller.contacts, robot.q_half_sitting, controller.dt)


def controller_of(case: Case, home: pin.SE3, **task) -> WholeBodyController:
    """Return what a user opens: a door, with one hand."""
    robot = get_robot(case.robot)
    hand = FramePoseTask("hand", robot.palms[-1].frame, home, **task)
    rotors = ROTORS if case.rotors or case.engine == "mujoco" else 0.0
    soft = robot.nv_base and (case.engine == "mujoco" or case.rotors)
    given = {} if case.margin is None else {"margin": case.margin}
    loop = LoopSettings(
        period=case.period, delay=0.003 if soft else 0.0, rotor_inertia=rotors, **given
    )
    door = WholeBodyController.standing if robot.nv_base else WholeBodyController.fixed
    return door(robot, tasks=[hand], loop=loop)


def run_case(case: Case, **task) -> Outcome:
    """Run a case; return how it ended."""
    home, far = target_of(case)
    controller = controller_of(case, home, **task)
    robot, hand, engine = controller.robot, controller.task("hand"), simulated(case, controller)
    dt, na = controller.dt, controller.robot.na
    state, height = engine.state, engine.state.q[2] if robot.nv_base else 1.0
    n = round(END / dt)
    v_ref, v, share = np.zeros((n, na)), np.zeros((n, na)), np.zeros(n)
    lowest, last, reached, wrong = 1.0, home, home.translation, []
    for k in range(n):
        t = k * dt
        wanted = where(t, home, far, case.how)
        if case.how == "drag" or (wanted.translation != last.translation).any():
            hand.target = last = wanted
        command = controller.step(t, state.q, state.v, state.lam)
        if controller.supervisor.mode is not Mode.RUN:
            wrong.append(str(controller.supervisor.changes[0]))
            break
        state = engine.step(command.tau)
        v_ref[k], v[k] = command.v_ref[robot.nv_base :], state.v[robot.nv_base :]
        share[k] = np.abs(command.tau / robot.tau_max).max()
        if robot.nv_base:
            lowest = min(lowest, state.q[2] / height)
        if k == round(BACK / dt) - 1:
            reached = robot.at(state.q).placement(hand.frame).translation.copy()
    end = robot.at(controller.motion.q_ref).placement(hand.frame).translation
    waited, ended = slice(round((BACK - 1.0) / dt), round(BACK / dt)), slice(n - round(0.5 / dt), n)
    waiting, moving = np.abs(v_ref[waited]).max(), np.abs(v[waited]).max()
    back = float(np.linalg.norm(end - home.translation))
    if lowest < STANDING:
        wrong.append(f"the base sank to {100 * lowest:.0f} %")
    if not wrong:
        if max(waiting, moving) > AT_REST:
            wrong.append(f"waiting it still moves, by {waiting:.2f} and {moving:.2f} rad/s")
        if np.abs(v[ended]).max() > AT_REST:
            wrong.append(f"in the end it still moves, by {np.abs(v[ended]).max():.2f} rad/s")
        if back > HOME:
            wrong.append(f"not back: {1e3 * back:.0f} mm")
    return Outcome(
        tuple(wrong), float(np.linalg.norm(reached - home.translation)),
        float(np.abs(np.diff(v_ref, axis=0)).max() / dt), float(np.abs(v).max()),
        float(waiting), float(share[waited].max()), back,
    )  # fmt: skip


def cases(given: argparse.Namespace) -> list[Case]:
    """Return the cases of a seed: each robot, engine, direction and way, by a random distance."""
    rng, found = random.Random(given.seed), []
    for robot in given.robots:
        for engine in given.engines:
            for direction in given.directions:
                for how in given.how:
                    beyond = given.beyond or round(rng.uniform(0.1, 1.5), 2)
                    found.append(Case(robot, engine, direction, beyond, how, given.period,
                                      given.rotors, given.margin))  # fmt: skip
    return found


def main() -> int:
    """Run the sweep that the command line asks for; return 1 if a case was not well."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robots", nargs="+", default=ROBOTS)
    parser.add_argument("--engines", nargs="+", default=("rigid", "mujoco"))
    parser.add_argument("--directions", nargs="+", default=tuple(DIRECTIONS))
    parser.add_argument("--how", nargs="+", default=("jump", "drag"))
    parser.add_argument("--beyond", type=float, help="[m], else by chance 0.1 to 1.5")
    parser.add_argument("--period", type=float, default=0.001)
    parser.add_argument("--margin", type=float, help="[m] of the balance, else the usual one")
    parser.add_argument("--rotors", action="store_true", help="in the rigid engine too")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    logging.disable(logging.WARNING)
    warnings.simplefilter("ignore")
    bad = total = 0
    for case in cases(given):
        found = run_case(case)
        total += 1
        bad += bool(found.wrong)
        print(
            f"{case.robot:6} {case.engine:6} {case.direction:8} +{case.beyond:.2f} m {case.how:5}"
            f" {'well ' if not found.wrong else 'WRONG'} {found}",
            flush=True,
        )
    print(f"{total - bad} of {total} well")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
