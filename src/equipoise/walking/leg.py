"""What a swinging leg weighs in: the way of the zero-moment point for each m/s^2 of its foot."""

from __future__ import annotations

import numpy as np

from equipoise.robots import Robot
from equipoise.walking.feet import Feet
from equipoise.walking.settings import GRAVITY


def leg_lever(robot: Robot, feet: Feet) -> float:
    """Return the lever [s^2] of a leg, from the nominal masses at half-sitting.

    With the centre of mass where it is wanted, what swings at a height z pushes against the rest of
    the robot, whose centre is at z_r: the zero-moment point goes by `m r (z_r - z) / (M g)` for
    each m/s^2 of the foot, where r tells how much of the foot's way a link goes: none at the hip,
    all of it at the sole, in between by its height. Turning links count as points.
    """
    model, kin = robot.model, robot.at(robot.q_half_sitting)
    ends = [model.frames[robot.frame_id(sole.frame)].parentJoint for sole in feet.soles]
    left, right = ([joint for joint in model.supports[end] if joint > 1] for end in ends)
    leg = [joint for joint in left if joint not in right]
    heights = {
        joint: float(kin.joint_placement(joint).act(model.inertias[joint].lever)[2])
        for joint in range(1, model.njoints)
    }
    masses = {joint: float(model.inertias[joint].mass) for joint in heights}
    rest = [joint for joint in heights if joint not in leg]
    z_rest = np.average([heights[j] for j in rest], weights=[masses[j] for j in rest])
    hip = float(kin.joint_placement(leg[0]).translation[2])
    sole = float(kin.placement(feet.left.frame).translation[2])
    lever = 0.0
    for joint in leg:
        share = float(np.clip((hip - heights[joint]) / (hip - sole), 0.0, 1.0))
        lever += masses[joint] * share * (z_rest - heights[joint])
    return float(lever / (sum(masses.values()) * GRAVITY))
