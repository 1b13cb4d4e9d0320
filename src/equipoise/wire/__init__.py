"""Robots behind a process boundary: what a robot offers to a loop, and a wire of plain UDP."""

from __future__ import annotations

from equipoise.wire.client import UdpRobot
from equipoise.wire.datagrams import LOCAL, PORT, Datagrams, UdpSocket
from equipoise.wire.interface import (
    CommandMode,
    RobotCommand,
    RobotInterface,
    RobotLostError,
    RobotMode,
    RobotState,
)
from equipoise.wire.model import WireModel
from equipoise.wire.packets import Codec, Fault, Kind
from equipoise.wire.server import UdpServer

__all__ = [
    "LOCAL",
    "PORT",
    "Codec",
    "CommandMode",
    "Datagrams",
    "Fault",
    "Kind",
    "RobotCommand",
    "RobotInterface",
    "RobotLostError",
    "RobotMode",
    "RobotState",
    "UdpRobot",
    "UdpServer",
    "UdpSocket",
    "WireModel",
]
