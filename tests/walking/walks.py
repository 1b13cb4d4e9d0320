"""Feet, stances and walks that the tests of walking share."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from equipoise.robots import Sole
from equipoise.walking import (
    LEFT,
    RIGHT,
    Feet,
    LedPose,
    TouchSettings,
    Walker,
    WalkPlanner,
    WalkSettings,
    WalkTargets,
)
from equipoise.walking.feet import level_pose

WEIGHT = 500.0  # [N]
DT = 2e-3  # [s]

FEET = Feet(
    Sole("left", "left", -0.1, 0.13, -0.056, 0.075),
    Sole("right", "right", -0.1, 0.13, -0.075, 0.056),
)
STANCE = (level_pose(0.0, 0.095, 0.0, 0.0), level_pose(0.0, -0.095, 0.0, 0.0))
SETTINGS = WalkSettings(0.78)
PLANNER = WalkPlanner(FEET, SETTINGS)
MIRROR = np.diag([1.0, -1.0, 1.0])


def walker_of(planner, steps, stance=STANCE, balance=None):
    plan = planner.begin(stance, steps)
    height = planner.settings.height
    middle = planner.feet.middle(stance)
    up = np.array([0.0, 0.0, height])
    upright = {"torso": LedPose(pin.SE3(middle.rotation, middle.translation + up))}
    targets = WalkTargets(tuple(LedPose(T) for T in stance), LedPose(middle), upright)
    return Walker(planner, plan, TouchSettings(0.03 * WEIGHT), targets, balance=balance)


def walk(walker, ground=lambda step: 0.0, miss=lambda step: np.zeros(3), most=30.0, each=None,
         bounced=lambda: None):  # fmt: skip
    """Let a robot without a body walk: it is where it is wanted, and the ground is where it is.

    `ground(step)` [m] is how high the floor is where a step lands, over the plan; `miss(step)` (3,)
    [m] by how much the foot is off when it lands; `bounced()` is a foot that landed and carries
    nothing. Returns the rows of the targets of every tick.
    """
    rows, t = [], 0.0
    while t < most and not walker.stands:
        soles = [led.at(t).T_world_target for led in walker.targets.soles]
        loads = [0.5 * WEIGHT, 0.5 * WEIGHT]
        step = walker.swinging
        if step is not None:
            foot = step.foot
            floor = step.footstep.T_world_sole.translation[2] + ground(step)
            loads[foot] = WEIGHT if soles[foot].translation[2] <= floor + 1e-12 else 0.0
            soles[foot].translation += miss(step)
        elif bounced() is not None:
            loads[bounced()] = 0.0
        walker.advance(t, DT, loads, lambda soles=tuple(soles): soles)
        if each is not None:
            each(t)
        led = (*walker.targets.soles, walker.targets.centre, *walker.targets.upright.values())
        rows.append([one.row(t).copy() for one in led])
        t += DT
    assert walker.stands
    return np.array(rows)


def mirrored(T):
    """Return a pose seen in the mirror y = 0."""
    return pin.SE3(MIRROR @ T.rotation @ MIRROR, MIRROR @ T.translation)


__all__ = ["DT", "FEET", "LEFT", "PLANNER", "RIGHT", "SETTINGS", "STANCE", "WEIGHT"]
