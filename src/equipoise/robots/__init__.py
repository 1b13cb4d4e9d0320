"""Robots: checked descriptions wrapped in a frozen `Robot`."""

from __future__ import annotations

from equipoise.robots.files.check import check_urdf
from equipoise.robots.files.finding import Finding
from equipoise.robots.files.source import ExtraMissingError
from equipoise.robots.load import load_robot
from equipoise.robots.registry import (
    NamedRobot,
    get_robot,
    named_robots,
    robot_path,
    robot_urdf_path,
)
from equipoise.robots.robot import Foot, Palm, Robot, Sole, require_robot

__all__ = [
    "ExtraMissingError",
    "Finding",
    "Foot",
    "NamedRobot",
    "Palm",
    "Robot",
    "Sole",
    "check_urdf",
    "get_robot",
    "load_robot",
    "named_robots",
    "require_robot",
    "robot_path",
    "robot_urdf_path",
]
