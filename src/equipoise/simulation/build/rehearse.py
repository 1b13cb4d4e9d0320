"""A walk rehearsed before it is run: the reference alone, on ground that is as it was planned.

What the plan cannot know is seen here: whether legs reach, whether joints come to their limits, and
where the zero-moment point of the whole robot would be, swinging legs and arms included.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from equipoise.errors import ScenarioError
from equipoise.hqp import make_solver
from equipoise.motion import MotionGenerator
from equipoise.robots import Robot
from equipoise.scenarios import schema
from equipoise.simulation.build.levels import build_levels
from equipoise.simulation.build.setup import Setup
from equipoise.simulation.build.walk import WalkSetup, build_walk
from equipoise.spatial import Array
from equipoise.walking import SteeredWalk, StickSchedule, Walker
from equipoise.walking.feasible import step_name
from equipoise.walking.feet import Stance

STEP = 0.02  # [s] of the rehearsal
SETTLES = 0.3  # [s] behind the plan
FAR = 0.01  # [m, rad] by which a foot or the centre of mass may be behind
OUTSIDE = 0.005  # [m] outside its soles at which a zero-moment point is told
COUNTED = 2  # ticks to either side over which an acceleration is averaged


@dataclass(frozen=True)
class Moment:
    """The reference of a tick: what carries, where, and how far feet and centre are behind [m]."""

    t: float
    q: Array
    v: Array
    carries: tuple[int, ...]
    stance: Stance
    step: str
    behind: float
    what: str


def rehearse(scenario: schema.Scenario, setup: Setup, q_start: Array) -> tuple[str, ...]:
    """Return what is told of a walk before it is run, in sentences; of a robot that stands nothing.

    Raises: `ScenarioError` naming the step that a leg cannot reach.
    """
    walk = build_walk(scenario, setup)
    if walk is None:
        return ()
    levels = build_levels(scenario, setup, walk)
    motion = MotionGenerator(
        setup.robot, levels, lambda: make_solver("active_set"), STEP, q_start, advise=False
    )
    end = walk.plan.end + SETTLES if walk.spec.steer is None else scenario.duration
    moments = moments_of(motion, walk, min(end, scenario.duration), walk.sticks)
    worst = next((one for one in moments if one.behind > FAR), None)
    if worst is not None:
        worst = max((one for one in moments if one.step == worst.step), key=lambda one: one.behind)
        raise ScenarioError(
            f"{worst.step} is out of reach: {worst.what} would be {1e3 * worst.behind:.0f} mm "
            f"from where it is wanted, at t = {worst.t:.2f} s",
            path="walk",
            remedy="Give shorter steps, a deeper crouch, or longer times",
        )
    room, moment = least_room(setup.robot, walk, moments)
    if room >= -OUTSIDE:
        return ()
    return (
        f"at {moment.step} the whole robot would have its zero-moment point {-1e3 * room:.0f} mm "
        f"outside its soles (t = {moment.t:.2f} s), by its nominal masses: longer times, shorter "
        "steps or joints farther from their limits are safer",
    )


def moments_of(
    motion: MotionGenerator, walk: WalkSetup, end: float, sticks: StickSchedule
) -> list[Moment]:
    """Let a reference walk up to `end` [s]; every foot finds the ground where it was planned.

    `motion` is by the tasks of the walk, its feet first in level 0, in steps of `STEP`; `sticks`
    are for a walk that is steered.
    """
    levels, robot = motion.levels, motion.robot
    com = next(task for level in levels for task in level if task.name == "walk com")
    tasks = [*levels[0][:2], com]
    names = [*(f"the {name} foot" for name in ("left", "right")), "the centre of mass"]
    walker, found = walk.walker(), []
    steered = walk.steered(walker)
    last = "the start"
    for k in range(round(end / STEP)):
        t = k * STEP
        if steered is not None:
            steered.stick = sticks.at(t)
        _let_it_feel(steered or walker, walker, walk, t)
        step = motion.step(t)
        if walker.swinging is not None:
            last = step_name(walker.swinging)
        kin = robot.at(step.q_ref)
        behind = [float(np.abs(task.error(kin, t)).max()) for task in tasks]
        far = int(np.argmax(behind))
        found.append(
            Moment(t, step.q_ref.copy(), step.v_ref.copy(), walker.supports, walker.stance, last,
                   behind[far], names[far])
        )  # fmt: skip
    return found


def _let_it_feel(leads: Walker | SteeredWalk, walker: Walker, walk: WalkSetup, t: float) -> None:
    """Advance the walker over ground that is where it was planned."""
    soles = walk.targets.soles
    loads = [0.5 * walk.weight, 0.5 * walk.weight]
    step = walker.swinging
    if step is not None:
        loads[step.foot] = walk.weight if walker.clock.t >= step.land - 1e-9 else 0.0
    here = tuple(led.at(t).T_world_target for led in soles)
    leads.advance(t, STEP, loads, lambda: (here[0], here[1]))


def least_room(robot: Robot, walk: WalkSetup, moments: list[Moment]) -> tuple[float, Moment]:
    """Return how far [m] inside its soles the zero-moment point of the whole robot stays, and when.

    Accelerations are differences over a few ticks: what a motor could give anyhow.
    """
    model = robot.model
    context = model.createData()
    least, when = np.inf, moments[0]
    for k in range(COUNTED, len(moments) - COUNTED):
        one = moments[k]
        after, before = moments[k + COUNTED].v, moments[k - COUNTED].v
        a = (after - before) / (2 * COUNTED * STEP)
        wrench = pin.Force(pin.rnea(model, context, one.q, one.v, a)[:6])
        f = pin.XYZQUATToSE3(one.q[:7]).act(wrench)
        floor = min(float(one.stance[foot].translation[2]) for foot in one.carries)
        lever = f.angular - np.cross([0.0, 0.0, floor], f.linear)
        zmp = np.array([-lever[1], lever[0]]) / f.linear[2]
        room = walk.planner.feet.support(one.stance, one.carries).margin(zmp)
        if room < least:
            least, when = room, one
    return float(least), when
