"""What `equipoise plant` does: the simulated robot of a scenario, served on a wire."""

from __future__ import annotations

import gc
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np

from equipoise.contacts import SoleContact
from equipoise.errors import InputError
from equipoise.physics import DivergedError
from equipoise.remote.far_end import FarEnd, FarEndSettings
from equipoise.remote.options import WireOptions
from equipoise.remote.realtime import Ticker, claim_machine, release_machine
from equipoise.remote.signals import StopSignals
from equipoise.remote.truth import Truth
from equipoise.robots import Robot
from equipoise.scenarios import Scenario
from equipoise.simulation.build.assemble import assemble_plant, starting_posture
from equipoise.simulation.build.setup import build_setup
from equipoise.simulation.build.walk import build_walk
from equipoise.simulation.simulated_robot import SimulatedRobot
from equipoise.spatial import Array
from equipoise.wire.interface import (
    CommandMode,
    RobotCommand,
    RobotMode,
)
from equipoise.wire.model import WireModel
from equipoise.wire.packets import Fault
from equipoise.wire.unitree.server import require_ticks

Say = Callable[[str], None]


def make_robot(scenario: Scenario, away: float = 0.0) -> SimulatedRobot:
    """Return the simulated robot of a scenario where it starts, its arms `away` [rad] from there.

    Raises: `InputError`, `ScenarioError`.
    """
    setup = build_setup(scenario)
    walk = build_walk(scenario, setup)
    q = starting_posture(scenario, setup, walk)
    if away:
        q = _moved_arms(setup.robot, q, away)
    plant, tau = assemble_plant(scenario, setup, q)
    if walk is not None:  # soles tell their wrenches in these axes to the end, wherever they land
        for contact in setup.soles.contacts:
            if isinstance(contact, SoleContact):
                plant.engine.support(contact.name, contact.T_world_anchor)
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


def serve_plant(
    scenario: Scenario,
    options: WireOptions,
    say: Say,
    truth: Path | None = None,
    away: float = 0.0,
) -> FarEnd:
    """Be the robot of a scenario until it was left and has come to rest; return how it ended.

    Its true states are written to `truth`, if that is given; it begins with its arms `away` [rad]
    from where the scenario starts. On Ctrl-C or SIGTERM it is on its own, on the second it ends as
    it is.
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
    signals = StopSignals()
    signals.take()
    try:
        far_end = FarEnd(robot, server, settings)
        pace = "waits for every command" if options.lockstep else "runs in real time"
        say(f"{robot.plant.robot.name} stands, {where}, and {pace}")

        def before_tick() -> None:
            cause = signals.asked()
            if cause:
                far_end.leave(cause)
            if truth is not None:
                states.note()

        if options.lockstep:
            _serve_in_lockstep(far_end, before_tick)
        else:
            _serve_in_time(far_end, period, say, before_tick)
        _report(far_end, say)
    finally:
        if truth is not None:
            states.save(truth)
        server.close()
        signals.give_back()
    return far_end


def _warm_up(robot: SimulatedRobot) -> None:
    """Let a robot that nobody needs go through all that a period may need: kernels are loaded."""
    tau = np.zeros(robot.plant.robot.na)
    for mode in (CommandMode.TORQUE, CommandMode.HOLD):
        for _ in range(3):
            robot.read(0.0)
            with suppress(DivergedError):  # without a torque it falls: no matter
                robot.write(RobotCommand(robot.t, mode, tau))


def _serve_in_lockstep(far_end: FarEnd, before_tick: Callable[[], None]) -> None:
    server = far_end.server
    while not far_end.ended:
        if not far_end.alone:
            server.wait(server.now() + 0.02)
        before_tick()
        far_end.tick()


def _serve_in_time(
    far_end: FarEnd, period: float, say: Say, before_tick: Callable[[], None]
) -> None:
    for sentence in claim_machine():
        say(sentence)
    gc.collect()
    gc.freeze()  # a collection that looks at all that is loaded takes a tenth of a second
    ticker = Ticker(period)
    while not far_end.ended:
        ticker.wait()
        before_tick()
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
