"""Puts a robot on wheels that go anywhere in the plane: three joints between the world and it."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from equipoise.errors import RobotFileError
from equipoise.robots.base import FIXED
from equipoise.robots.files.described import Described
from equipoise.robots.files.extras_schema import WheelsEntry

PLANAR = "planar"
JOINTS = ("base_x", "base_y", "base_yaw")
TURNS = 200.0 * np.pi  # [rad] each way: as of a continuous joint


def without_wheels(base: str | None) -> str | None:
    """Return the kind of base that the file's own first link has below the wheels."""
    return FIXED.kind if base == PLANAR else base


def roll_base(described: Described, wheels: WheelsEntry) -> None:
    """Let the first link slide along x and y of the world and turn about z, driven as joints are.

    They are called `base_x`, `base_y` and `base_yaw` and come first. Raises: RobotFileError if the
    robot has joints of these names.
    """
    taken = sorted(set(JOINTS) & set(described.model.names))
    if taken:
        raise RobotFileError(
            f"the robot has joints that the planar base needs: {', '.join(taken)}",
            remedy="Say base: fixed: it has a base that moves of its own",
        )
    model, effort = pin.Model(), [wheels.force, wheels.force, wheels.moment]
    model.name, model.gravity = described.model.name, described.model.gravity
    kinds = pin.JointModelPX(), pin.JointModelPY(), pin.JointModelRZ()
    speed = [wheels.speed, wheels.speed, wheels.turn]
    far = [wheels.reach, wheels.reach, TURNS]
    joint = 0
    for k, (kind, name) in enumerate(zip(kinds, JOINTS, strict=True)):
        limits = (np.array([value]) for value in (effort[k], speed[k], -far[k], far[k]))
        joint = model.addJoint(joint, kind, pin.SE3.Identity(), name, *limits)
        model.addJointFrame(joint)
    top, here = model.getFrameId(JOINTS[-1]), pin.SE3.Identity()
    _, described.visual = pin.appendModel(
        model, described.model, pin.GeometryModel(), described.visual, top, here
    )
    described.model, described.collision = pin.appendModel(
        model, described.model, pin.GeometryModel(), described.collision, top, here
    )
