"""Puts a fixed base where the robot's YAML says, by moving all that hangs on it."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from equipoise.errors import RobotFileError
from equipoise.robots.base import FIXED
from equipoise.robots.files.described import Described
from equipoise.robots.files.extras_schema import PlaceEntry


def place_base(described: Described, place: PlaceEntry | None) -> None:
    """Move the first link, and all that is fixed to it, to its place in the world.

    Raises: RobotFileError for a base that floats: it is where its configuration says.
    """
    if place is None:
        return
    if described.base is not FIXED:
        raise RobotFileError(
            "base_at is for a base that is fixed, and this one floats",
            remedy="Say base: fixed too, or leave base_at out",
        )
    T = pin.SE3(pin.rpy.rpyToMatrix(*place.rpy), np.array(place.xyz))
    model = described.model
    for joint in range(1, model.njoints):
        if model.parents[joint] == 0:
            model.jointPlacements[joint] = T * model.jointPlacements[joint]
    model.inertias[0] = T.act(model.inertias[0])
    for frame in list(model.frames)[1:]:  # the first one is the world itself
        if frame.parentJoint == 0:
            frame.placement = T * frame.placement
    for shapes in (described.collision, described.visual):
        for shape in shapes.geometryObjects:
            if shape.parentJoint == 0:
                shape.placement = T * shape.placement
