"""Robots: checked descriptions wrapped in a frozen `Robot`."""

from __future__ import annotations

from equipoise.robots.check import check_urdf
from equipoise.robots.finding import Finding
from equipoise.robots.load import load_robot
from equipoise.robots.registry import (
    NamedRobot,
    get_robot,
    named_robots,
    robot_path,
    robot_urdf_path,
)
from equipoise.robots.robot import Palm, Robot, Sole
from equipoise.robots.source import ExtraMissingError

__all__ = [
    "ExtraMissingError",
    "Finding",
    "NamedRobot",
    "Palm",
    "Robot",
    "Sole",
    "check_urdf",
    "get_robot",
    "load_robot",
    "named_robots",
    "robot_path",
    "robot_urdf_path",
]
