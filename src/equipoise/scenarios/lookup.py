"""Small steps from scenario to objects that every builder takes: poses, names, complaints."""

from __future__ import annotations

from collections.abc import Sequence

import pinocchio as pin

from equipoise.errors import InputError, NameNotFoundError, ScenarioError
from equipoise.robots import Robot
from equipoise.scenarios import schema
from equipoise.spatial import pose


def to_pose(spec: schema.Pose) -> pin.SE3:
    """Return the placement that a `Pose` section describes."""
    return pose(spec.xyz, spec.rpy)


def to_vector(values: Sequence[float]) -> tuple[float, float, float]:
    """Return the three numbers of a vector in a scenario."""
    x, y, z = values
    return x, y, z


def frame_of(robot: Robot, name: str, path: str) -> str:
    """Return the name of a frame, checked to be one that moves with the robot.

    Raises: `ScenarioError` with the path.
    """
    try:
        frame_id = robot.frame_id(name)
    except NameNotFoundError as error:
        raise at_path(error, path) from None
    if robot.model.frames[frame_id].parentJoint == 0:
        raise ScenarioError(
            f"frame {name!r} belongs to the world, not to robot {robot.name}",
            path=path,
            remedy="Name a link or a frame that is fixed to one",
        )
    return name


def at_path(error: InputError, path: str) -> ScenarioError:
    """Return the same complaint with the path of the scenario where it comes from."""
    return ScenarioError(
        error.problem, path=path, given=error.given, known=error.known, remedy=error.remedy
    )
