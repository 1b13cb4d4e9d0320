"""What `equipoise plant` and `equipoise control` do: the two ends of a wire as programs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from equipoise.errors import InputError
from equipoise.remote.drive import RemoteRun
from equipoise.remote.far_end import FarEnd, FarEndSettings
from equipoise.remote.realtime import Ticker, claim_machine
from equipoise.scenarios import Scenario
from equipoise.simulation.build.assemble import assemble_plant, starting_posture
from equipoise.simulation.build.setup import build_setup
from equipoise.simulation.simulated_robot import SimulatedRobot
from equipoise.wire.client import UdpRobot
from equipoise.wire.datagrams import PORT, Address, UdpSocket, own_side, resolved
from equipoise.wire.interface import RobotMode
from equipoise.wire.model import WireModel
from equipoise.wire.packets import Codec, Fault
from equipoise.wire.server import UdpServer

Say = Callable[[str], None]
WIRES = ("udp",)


@dataclass(frozen=True)
class WireOptions:
    """Which wire, where, and whether the robot's time waits for commands."""

    wire: str = "udp"
    host: str = "127.0.0.1"
    port: int = PORT
    lockstep: bool = True

    def __post_init__(self) -> None:
        if self.wire not in WIRES:
            raise InputError(f"there is no wire {self.wire!r}", known=WIRES)

    @property
    def address(self) -> Address:
        """Where the robot listens."""
        return resolved(self.host), self.port

    def connect(self, model: WireModel) -> UdpRobot:
        """Return the robot behind the wire. Raises: `InputError`."""
        robot = self.address
        socket = UdpSocket((own_side(robot[0]), 0), Codec(model).longest)
        return UdpRobot(model, socket, robot)


def make_robot(scenario: Scenario) -> SimulatedRobot:
    """Return the simulated robot of a scenario where it starts."""
    setup = build_setup(scenario)
    plant, tau = assemble_plant(scenario, setup, starting_posture(scenario, setup))
    return SimulatedRobot(plant, scenario.control.period, tau)


def control_robot(scenario: Scenario, options: WireOptions, say: Say) -> RemoteRun:
    """Return a run whose robot was met, looked at and found good; nothing was commanded yet.

    Raises: `RobotLostError`, `InputError`, `ScenarioError`.
    """
    run = RemoteRun(scenario, options.connect, lockstep=options.lockstep)
    try:
        for sentence in run.meet():
            say(sentence)
        if not options.lockstep:
            for sentence in claim_machine():
                say(sentence)
    except BaseException:
        run.close()
        raise
    return run


def serve_plant(scenario: Scenario, options: WireOptions, say: Say) -> FarEnd:
    """Be the robot of a scenario until it was left and has come to rest; return how it ended.

    Ctrl-C ends it as it is. Raises: `InputError`, `ScenarioError`.
    """
    robot = make_robot(scenario)
    contacts, period = robot.plant.contacts, scenario.control.period
    model = WireModel.of(robot.plant.robot, contacts, period, lockstep=options.lockstep)
    settings = FarEndSettings(options.lockstep)
    socket = UdpSocket(options.address, Codec(model).longest)
    server = UdpServer(model, socket, settings.oldest)
    try:
        far_end = FarEnd(robot, server, settings)
        pace = "waits for every command" if options.lockstep else "runs in real time"
        host, port = socket.address
        say(f"{robot.plant.robot.name} stands, listens at {host} port {port}, and {pace}")
        if options.lockstep:
            _serve_in_lockstep(far_end)
        else:
            _serve_in_time(far_end, period, say)
        _report(far_end, say)
    finally:
        server.close()
    return far_end


def _serve_in_lockstep(far_end: FarEnd) -> None:
    server = far_end.server
    while not far_end.ended:
        if not far_end.alone:
            server.wait(server.now() + 0.02)
        far_end.tick()


def _serve_in_time(far_end: FarEnd, period: float, say: Say) -> None:
    for sentence in claim_machine():
        say(sentence)
    ticker = Ticker(period)
    while not far_end.ended:
        ticker.wait()
        far_end.tick()
    say(ticker.lateness.sentence(period))


def _report(far_end: FarEnd, say: Say) -> None:
    after = far_end.aftermath
    say(far_end.cause)
    said = {RobotMode.HELD: "It held itself", RobotMode.SUNK: "It let its weight down"}
    say(
        f"{said.get(after.ended, 'It stopped')}: it came down by {1e3 * after.lowered:.0f} mm, "
        f"its base moved at {after.fastest_base:.2f} m/s at most, "
        f"a joint at {after.fastest_joint:.2f} rad/s"
    )
    for sentence in told_of(far_end.server.dropped):
        say(sentence)


def told_of(dropped: Mapping[Fault, int]) -> Sequence[str]:
    """Return in words which packets were dropped."""
    words = ", ".join(f"{n} {fault.value}" for fault, n in dropped.items())
    return [f"Packets dropped: {words}"] if words else []
