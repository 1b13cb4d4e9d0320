"""The robots that have a name, and one way to get any robot by name or by path."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from equipoise.errors import InputError, NameNotFoundError
from equipoise.robots.load import load_robot
from equipoise.robots.robot import Robot

HERE = Path(__file__).resolve().parent


@dataclass(frozen=True)
class NamedRobot:
    """A robot that comes with Equipoise: where its description is and what it is."""

    summary: str
    urdf_path: Path


ROBOTS = {
    "hrp2": NamedRobot(
        "HRP-2, 30 joints, 56 kg: the paper's robot, put together from public numbers",
        HERE / "hrp2" / "hrp2.urdf",
    ),
}


def named_robots() -> dict[str, NamedRobot]:
    """Return name -> what is known of each named robot."""
    return dict(ROBOTS)


def robot_urdf_path(name: str) -> Path:
    """Return the path of a named robot's URDF.

    Raises: NameNotFoundError.
    """
    if name not in ROBOTS:
        raise NameNotFoundError("robot", name, ROBOTS, remedy="Or give the path of a .urdf file")
    return ROBOTS[name].urdf_path


def get_robot(name_or_path: str | Path) -> Robot:
    """Load a robot by its name, or by the path of a .urdf file.

    Raises: NameNotFoundError, RobotFileError.
    """
    if not isinstance(name_or_path, (str, Path)):
        raise InputError(
            "A robot is named by a string or a path", given=name_or_path, known=sorted(ROBOTS)
        )
    if isinstance(name_or_path, Path) or name_or_path.lower().endswith((".urdf", ".xml")):
        return load_robot(name_or_path)
    return load_robot(robot_urdf_path(name_or_path))
