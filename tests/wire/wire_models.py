"""Small models, states and ends of a wire for its tests."""

from __future__ import annotations

import numpy as np

from equipoise.wire import CommandMode, RobotCommand, RobotMode, RobotState, UdpRobot, UdpServer
from equipoise.wire.model import WireModel, hash_of
from equipoise.wire.virtual import NetworkFaults, VirtualNetwork

ROBOT, LOOP, OTHER = ("robot", 1), ("loop", 2), ("other", 3)


def model(tau_max: float = 10.0) -> WireModel:
    """Return a model with odd sizes, all of them different."""
    limits = np.full(3, tau_max)
    return WireModel(10, 9, 3, 5, limits, hash_of(["one"], [limits]))


def state(t: float, seed: int = 0) -> RobotState:
    """Return a state whose numbers are all different; one of them says nothing."""
    random = np.random.default_rng(seed)
    q = random.normal(size=10)
    q[3] = np.nan
    stamps = np.array([-np.inf, t, t - 1e-3, t])
    parts = random.normal(size=9), random.normal(size=5), random.normal(size=3)
    return RobotState(1, t, RobotMode.DRIVEN, stamps, q, *parts)


def torque(t: float, *tau: float) -> RobotCommand:
    """Return a command of a torque (3,)."""
    return RobotCommand(t, CommandMode.TORQUE, np.array(tau or (1.0, -2.0, 3.0)))


def two_ends(
    faults: NetworkFaults | None = None, seed: int = 0
) -> tuple[VirtualNetwork, UdpServer, UdpRobot]:
    """Return a network with a robot's end, which takes commands up to 20 ms old, and a loop's."""
    network = VirtualNetwork(faults or NetworkFaults(), seed)
    server = UdpServer(model(), network.place(ROBOT), 0.02)
    return network, server, UdpRobot(model(), network.place(LOOP), ROBOT)


def acquainted() -> tuple[VirtualNetwork, UdpServer, UdpRobot]:
    """Return two ends of which the loop's has read a state of t = 1 s."""
    network, server, robot = two_ends()
    assert robot.read(0.001) is None  # says hello
    server.receive(1.0)
    server.send(state(1.0))
    assert robot.read(0.001) is not None
    return network, server, robot
