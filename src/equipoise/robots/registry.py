"""The robots that have a name, and one way to get any robot by name or by path."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from equipoise.errors import InputError, NameNotFoundError
from equipoise.robots.files.extras import read_extras
from equipoise.robots.files.source import URDF, YAML, ExtraMissingError, urdf_of
from equipoise.robots.load import load_robot
from equipoise.robots.robot import Robot

HERE = Path(__file__).resolve().parent


@dataclass(frozen=True)
class NamedRobot:
    """A robot that comes with Equipoise: its YAML and what it is.

    `missing` says what has to be installed before it can be loaded; empty if nothing.
    """

    summary: str
    path: Path
    missing: str = ""


def named_robots() -> dict[str, NamedRobot]:
    """Return name -> what is known of each named robot."""
    return {name: _known(path) for name, path in _files().items()}


def robot_path(name: str) -> Path:
    """Return the path of a named robot's YAML.

    Raises: NameNotFoundError.
    """
    files = _files()
    if name not in files:
        remedy = "Or give the path of a .urdf file, of a robot's .yaml, or of its folder"
        raise NameNotFoundError("robot", name, files, remedy=remedy)
    return files[name]


def robot_urdf_path(name: str) -> Path:
    """Return the path of a named robot's URDF.

    Raises: NameNotFoundError, RobotFileError.
    """
    path = robot_path(name)
    return urdf_of(path, read_extras(path))


def get_robot(name_or_path: str | Path) -> Robot:
    """Load a robot by its name, or by the path of its URDF, its YAML or their folder.

    Raises: NameNotFoundError, RobotFileError.
    """
    if not isinstance(name_or_path, (str, Path)):
        raise InputError(
            "A robot is named by a string or a path", given=name_or_path, known=sorted(_files())
        )
    return load_robot(name_or_path if is_path(name_or_path) else robot_path(str(name_or_path)))


def is_path(name_or_path: str | Path) -> bool:
    """Say whether a robot is meant by its path: a file's suffix or a separator tells."""
    if isinstance(name_or_path, Path):
        return True
    return name_or_path.lower().endswith((*URDF, *YAML)) or os.sep in name_or_path


def _files() -> dict[str, Path]:
    """Return name -> YAML: every folder beside this file that holds one of its own name."""
    folders = sorted(folder for folder in HERE.iterdir() if folder.is_dir())
    files = {folder.name: folder / f"{folder.name}.yaml" for folder in folders}
    return {name: path for name, path in files.items() if path.is_file()}


def _known(path: Path) -> NamedRobot:
    extras = read_extras(path)
    try:
        urdf_of(path, extras)
    except ExtraMissingError as error:
        return NamedRobot(extras.summary, path, error.remedy)
    return NamedRobot(extras.summary, path)
