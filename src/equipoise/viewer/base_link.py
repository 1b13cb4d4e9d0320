"""The link that a free base carries: where a robot is pushed."""

from __future__ import annotations

import pinocchio as pin

from equipoise.robots import Robot


def base_link(robot: Robot) -> str:
    """Return the name of the link that the base carries, or of the first that moves."""
    for frame in robot.model.frames:
        if frame.type == pin.FrameType.BODY and frame.parentJoint == 1:
            return str(frame.name)
    return str(robot.model.names[1])
