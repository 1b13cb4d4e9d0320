"""What `equipoise plant` and `equipoise control` do: the two ends of a wire as programs."""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from equipoise.errors import InputError
from equipoise.estimation import EstimatingRobot
from equipoise.physics import DivergedError
from equipoise.remote.bring_up import BroughtUp
from equipoise.remote.drive import RemoteRun
from equipoise.remote.far_end import FarEnd, FarEndSettings
from equipoise.remote.realtime import Ticker, claim_machine, release_machine
from equipoise.remote.truth import Truth
from equipoise.robots import Robot
from equipoise.scenarios import Scenario
from equipoise.simulation.build.assemble import Controls, assemble_plant, starting_posture
from equipoise.simulation.build.setup import build_setup
from equipoise.simulation.simulated_robot import SimulatedRobot
from equipoise.spatial import Array
from equipoise.wire.client import UdpRobot
from equipoise.wire.datagrams import LOCAL, PORT, Address, UdpSocket, own_side, resolved
from equipoise.wire.interface import (
    CommandMode,
    RobotCommand,
    RobotInterface,
    RobotMode,
    RobotServer,
)
from equipoise.wire.model import WireModel
from equipoise.wire.packets import Codec, Fault
from equipoise.wire.server import UdpServer
from equipoise.wire.session import RecordingRobot, SessionRobot
from equipoise.wire.unitree.dds import LOOPBACK, DdsEnd, DdsOptions
from equipoise.wire.unitree.robot import UnitreeRobot
from equipoise.wire.unitree.server import UnitreeServer, require_ticks

Say = Callable[[str], None]
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


def make_robot(scenario: Scenario, away: float = 0.0) -> SimulatedRobot:
    """Return the simulated robot of a scenario where it starts, its arms `away` [rad] from there.

    Raises: `InputError`, `ScenarioError`.
    """
    setup = build_setup(scenario)
    q = starting_posture(scenario, setup)
    if away:
        q = _moved_arms(setup.robot, q, away)
    plant, tau = assemble_plant(scenario, setup, q)
    return SimulatedRobot(plant, scenario.control.period, tau)


def _moved_arms(robot: Robot, q: Array, by: float) -> Array:
    """Return a configuration whose joints of one arm alone are nearer to their middle by `by`."""
    kin = robot.at(q)
    moves = [np.abs(kin.jacobian(palm.frame)).max(axis=0) > 0.0 for palm in robot.palms]
    if len(moves) != 2:
        raise InputError(f"{robot.name} has no two arms", given=len(moves))
    arms = np.logical_xor(*moves)[robot.nv_base :]
    moved, joints = q.copy(), q[robot.nq_base :]
    middle = 0.5 * (robot.q_min + robot.q_max)
    moved[robot.nq_base :] += np.where(arms, np.copysign(by, middle - joints), 0.0)
    return moved


def control_robot(scenario: Scenario, options: WireOptions, say: Say) -> RemoteRun:
    """Return a run whose robot was met, looked at and found good; nothing was commanded yet.

    Raises: `RobotLostError`, `InputError`, `ScenarioError`.
    """
    run = RemoteRun(scenario, options.connect, lockstep=options.lockstep)
    try:
        for sentence in run.meet():
            say(sentence)
        for link in _chain(run.link):
            if isinstance(link, BroughtUp) and link.told:
                say(link.told)
        if not options.lockstep:
            for sentence in claim_machine():
                say(sentence)
            run.released = release_machine
        for link in _chain(run.link):
            if isinstance(link, SessionRobot):
                run.released = partial(_compare, run, link)
    except BaseException:
        run.close()
        raise
    return run


def _chain(link: RobotInterface) -> Iterator[RobotInterface]:
    """Yield a link, what is behind it, and so on."""
    behind: RobotInterface | None = link
    while behind is not None:
        yield behind
        behind = getattr(behind, "behind", None)


def _compare(run: RemoteRun, session: SessionRobot) -> None:
    run.tell(session.sentence())


def serve_plant(
    scenario: Scenario,
    options: WireOptions,
    say: Say,
    truth: Path | None = None,
    away: float = 0.0,
) -> FarEnd:
    """Be the robot of a scenario until it was left and has come to rest; return how it ended.

    Its true states are written to `truth`, if that is given; it begins with its arms `away` [rad]
    from where the scenario starts. Ctrl-C ends it as it is.
    Raises: `InputError`, `ScenarioError`.
    """
    if options.session is not None:
        raise InputError("a session is no robot", remedy="It is for equipoise control")
    robot = make_robot(scenario, away)
    if not options.lockstep:
        _warm_up(make_robot(scenario))
    contacts, period = robot.plant.contacts, scenario.control.period
    model = WireModel.of(robot.plant.robot, contacts, period, lockstep=options.lockstep)
    settings, states = FarEndSettings(options.lockstep), Truth(robot)
    if options.wire == "unitree":
        require_ticks(period)
    server, where = options.serve(model, robot.plant.robot, settings.oldest)
    try:
        far_end = FarEnd(robot, server, settings)
        pace = "waits for every command" if options.lockstep else "runs in real time"
        say(f"{robot.plant.robot.name} stands, {where}, and {pace}")
        note = states.note if truth is not None else _note_nothing
        if options.lockstep:
            _serve_in_lockstep(far_end, note)
        else:
            _serve_in_time(far_end, period, say, note)
        _report(far_end, say)
    finally:
        if truth is not None:
            states.save(truth)
        server.close()
    return far_end


def _warm_up(robot: SimulatedRobot) -> None:
    """Let a robot that nobody needs go through all that a period may need: kernels are loaded."""
    tau = np.zeros(robot.plant.robot.na)
    for mode in (CommandMode.TORQUE, CommandMode.HOLD):
        for _ in range(3):
            robot.read(0.0)
            with suppress(DivergedError):  # without a torque it falls: no matter
                robot.write(RobotCommand(robot.t, mode, tau))


def _note_nothing() -> None:
    pass


def _serve_in_lockstep(far_end: FarEnd, note: Callable[[], None]) -> None:
    server = far_end.server
    while not far_end.ended:
        if not far_end.alone:
            server.wait(server.now() + 0.02)
        note()
        far_end.tick()


def _serve_in_time(far_end: FarEnd, period: float, say: Say, note: Callable[[], None]) -> None:
    for sentence in claim_machine():
        say(sentence)
    gc.collect()
    gc.freeze()  # a collection that looks at all that is loaded takes a tenth of a second
    ticker = Ticker(period)
    while not far_end.ended:
        ticker.wait()
        note()
        far_end.tick()
    gc.unfreeze()
    release_machine()
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
