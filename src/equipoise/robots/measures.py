"""How large a robot is: where its shoulders are, how far its arms reach, how deep it stands."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pinocchio as pin

from equipoise.errors import InputError
from equipoise.robots.robot import Robot


@dataclass(frozen=True)
class Measures:
    """A robot's proportions at half-sitting.

    `p_world_shoulders` (3,) [m] is the middle between the shoulders, `reach` [m] the length of a
    stretched arm from shoulder to palm, `stance` [m] the half depth of the support, `height` [m]
    that of the centre of mass over the soles; both are 1 with a base that is fixed.
    """

    p_world_shoulders: np.ndarray
    reach: float
    stance: float
    height: float


def measure(robot: Robot) -> Measures:
    """Return the proportions of a robot with two palms and at least one sole.

    One whose base is fixed needs one palm or two, and nothing to stand on.
    An arm is what leads to one palm and not to the other; its shoulder is its second joint, where
    with humanoids the axes of the first three joints meet or nearly do.
    Raises: InputError.
    """
    fixed = robot.base.kind == "fixed"
    if (len(robot.palms) != 2 and not (fixed and robot.palms)) or not (robot.soles or fixed):
        wanted = "one palm or two" if fixed else "two palms and at least one sole"
        raise InputError(
            f"Robot {robot.name} cannot be measured: it needs {wanted}",
            given=f"{len(robot.palms)} palms, {len(robot.soles)} soles",
            remedy="List them in the robot's YAML",
        )
    placements = robot.model.createData()
    pin.framesForwardKinematics(robot.model, placements, robot.q_half_sitting)
    first, *others = (_joints_to(robot, palm.frame) for palm in robot.palms[:2])
    arms = [first]
    for second in others:
        arms = [_without(first, second), _without(second, first)]
    shoulders, lengths = [], []
    for palm, arm in zip(robot.palms, arms, strict=False):
        points = [placements.oMi[joint].translation.copy() for joint in arm[1:] or arm]
        points.append(placements.oMf[robot.frame_id(palm.frame)].translation.copy())
        shoulders.append(points[0])
        lengths.append(float(sum(np.linalg.norm(b - a) for a, b in pairwise(points))))
    if fixed:
        return Measures(np.mean(shoulders, axis=0), float(np.mean(lengths)), 1.0, 1.0)
    corners = [
        placements.oMf[robot.frame_id(sole.frame)].act(corner)[0]
        for sole in robot.soles
        for corner in sole.corners
    ]
    floor = [placements.oMf[robot.frame_id(sole.frame)].translation[2] for sole in robot.soles]
    return Measures(
        np.mean(shoulders, axis=0),
        float(np.mean(lengths)),
        float(max(corners) - min(corners)) / 2.0,
        float(robot.at(robot.q_half_sitting).p_world_com[2] - min(floor)),
    )


def _joints_to(robot: Robot, frame: str) -> list[int]:
    """Return the joints from the base to a frame."""
    joint = robot.model.frames[robot.frame_id(frame)].parentJoint
    return list(robot.model.supports[joint])[1:]


def _without(joints: list[int], other: list[int]) -> list[int]:
    arm = [joint for joint in joints if joint not in other]
    if not arm:
        raise InputError("The two palms hang on the same arm", remedy="Correct the robot's YAML")
    return arm
