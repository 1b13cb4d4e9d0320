"""Which wire joins robot and controller, and both ends of it made."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from equipoise.errors import InputError
from equipoise.estimation import EstimatingRobot
from equipoise.remote.bring_up import BroughtUp
from equipoise.robots import Robot
from equipoise.simulation.build.assemble import Controls
from equipoise.wire.client import UdpRobot
from equipoise.wire.datagrams import LOCAL, PORT, Address, UdpSocket, own_side, resolved
from equipoise.wire.interface import (
    RobotInterface,
    RobotServer,
)
from equipoise.wire.model import WireModel
from equipoise.wire.packets import Codec
from equipoise.wire.server import UdpServer
from equipoise.wire.session import RecordingRobot, SessionRobot
from equipoise.wire.unitree.dds import LOOPBACK, DdsEnd, DdsOptions
from equipoise.wire.unitree.robot import UnitreeRobot
from equipoise.wire.unitree.server import UnitreeServer, require_ticks

WIRES = ("udp", "unitree")
SESSION = "session:"  # before the name of a file


@dataclass(frozen=True)
class WireOptions:
    """Which wire, where, and whether the robot's time waits for commands.

    Of unitree `host` is a network interface, this machine alone by default, and `port` the domain
    of DDS. `wire` may also be `session:FILE`, a session that is read again; `record` is the file
    that a session is written to. One who is `armed` may move the robot before the run begins.
    """

    wire: str = "udp"
    host: str = LOCAL
    port: int | None = None
    lockstep: bool = True
    record: Path | None = None
    armed: bool = False

    def __post_init__(self) -> None:
        if self.wire not in WIRES and self.session is None:
            raise InputError(f"there is no wire {self.wire!r}", known=(*WIRES, f"{SESSION}FILE"))
        if self.session is not None and not self.lockstep:
            raise InputError("a session has no time of its own", remedy="Leave --realtime out")

    @property
    def session(self) -> Path | None:
        """The session that is read again, None for a robot."""
        begins = self.wire.startswith(SESSION)
        return Path(self.wire.removeprefix(SESSION)) if begins else None

    @property
    def address(self) -> Address:
        """Where the robot listens."""
        return resolved(self.host), PORT if self.port is None else self.port

    def connect(self, controls: Controls, model: WireModel) -> RobotInterface:
        """Return the robot behind the wire, with what it does not measure estimated.

        Raises: `InputError`.
        """
        setup, period = controls.setup, controls.scenario.control.period
        digest = WireModel.of(setup.robot, setup.contacts, period, lockstep=True).digest
        if self.session is not None:
            replayed = SessionRobot(self.session, digest)
            return replayed if replayed.measures_base else _estimating(replayed, controls)
        link = self._unitree(controls, model) if self.wire == "unitree" else self._udp(model)
        if self.armed:
            link = BroughtUp(link, setup.robot, controls.q_start[setup.robot.nq_base :])
        if self.record is not None:
            link = RecordingRobot(link, self.record, digest)
        return _estimating(link, controls) if self.wire == "unitree" else link

    def _udp(self, model: WireModel) -> RobotInterface:
        robot = self.address
        socket = UdpSocket((own_side(robot[0]), 0), Codec(model).longest)
        return UdpRobot(model, socket, robot)

    def _unitree(self, controls: Controls, model: WireModel) -> RobotInterface:
        require_ticks(controls.scenario.control.period)
        dds = DdsEnd("rt/lowstate", "rt/lowcmd", self._dds())
        return UnitreeRobot(controls.setup.robot, model.rows, dds)

    def _dds(self) -> DdsOptions:
        interface = LOOPBACK if self.host == LOCAL else self.host
        return DdsOptions(self.port or 0, interface)

    def serve(self, model: WireModel, robot: Robot, oldest: float) -> tuple[RobotServer, str]:
        """Return the robot's end, and in words where it listens. Raises: `InputError`."""
        if self.wire == "unitree":
            dds = DdsEnd("rt/lowcmd", "rt/lowstate", self._dds())
            return UnitreeServer(
                robot, dds, oldest
            ), f"speaks unitree_hg in domain {self.port or 0}"
        socket = UdpSocket(self.address, Codec(model).longest)
        host, port = socket.address
        return UdpServer(model, socket, oldest), f"listens at {host} port {port}"


def _estimating(link: RobotInterface, controls: Controls) -> EstimatingRobot:
    """Return a robot with what it does not measure estimated."""
    setup, physics = controls.setup, controls.scenario.physics
    return EstimatingRobot(
        link,
        setup.robot,
        setup.contacts,
        setup.schedule,
        rotor_inertia=physics.mujoco.armature if physics.engine == "mujoco" else 0.0,
    )
