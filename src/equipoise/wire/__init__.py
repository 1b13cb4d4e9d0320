"""Robots behind a process boundary: what a robot offers to a loop, and a wire of plain UDP."""

from __future__ import annotations

from equipoise.wire.interface import (
    CommandMode,
    RobotCommand,
    RobotInterface,
    RobotMode,
    RobotState,
)
from equipoise.wire.model import WireModel
from equipoise.wire.packets import Codec, Fault, Kind
from equipoise.wire.udp import UdpRobot, UdpServer

__all__ = [
    "Codec",
    "CommandMode",
    "Fault",
    "Kind",
    "RobotCommand",
    "RobotInterface",
    "RobotMode",
    "RobotState",
    "UdpRobot",
    "UdpServer",
    "WireModel",
]
