"""A session of controller and robot in one process and virtual time, over a network with faults."""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass, field
from typing import Literal, cast

import numpy as np
import pinocchio as pin

from equipoise.remote.drive import RemoteRun
from equipoise.remote.far_end import FarEnd, FarEndSettings
from equipoise.runlog import TickRecord
from equipoise.scenarios import schema
from equipoise.simulation.build.assemble import Prepared, assemble_plant
from equipoise.simulation.build.setup import build_setup
from equipoise.simulation.simulated_robot import SimulatedRobot
from equipoise.spatial import Array
from equipoise.wire.client import UdpRobot
from equipoise.wire.interface import RobotCommand, RobotLostError
from equipoise.wire.model import WireModel
from equipoise.wire.server import UdpServer
from equipoise.wire.virtual import NetworkFaults, VirtualNetwork

See = Callable[[float, TickRecord], None]
ROBOT, LOOP = ("robot", 1), ("loop", 2)
AFTER = 5.0  # [s] that the network goes on after the session, at most
WATCHED = 1.5  # [s] that the robot is watched once it is on its own
FALLEN_TILT, FALLEN_BY = 0.5, 0.15  # [rad], [m] of the base


@dataclass(frozen=True)
class Rehearsed:
    """What is tried: the network's faults, and who is killed at what time [s], if anybody."""

    faults: NetworkFaults
    seed: int
    killed: Literal["", "loop", "robot"] = ""
    at: float = np.inf


@dataclass
class Outcome:
    """How it went.

    `ticks` of the loop; `ended` in words; `share` the largest share of a torque limit that the
    robot was told, infinite if a number was not finite; `tilt` [rad], `lowered` [m] of the base at
    worst, from the start; `fastest` [m/s] of the base while the robot was on its own.
    """

    ticks: int = 0
    ended: str = "completed"
    share: float = 0.0
    tilt: float = 0.0
    lowered: float = 0.0
    fastest: float = 0.0
    told: list[str] = field(default_factory=list)

    @property
    def fell(self) -> bool:
        """Whether the robot fell."""
        return not (self.tilt < FALLEN_TILT and self.lowered < FALLEN_BY)


class WatchedRobot(SimulatedRobot):
    """A simulated robot that notes what it is told and how it stands."""

    def __init__(self, outcome: Outcome, scenario: schema.Scenario, prepared: Prepared) -> None:
        setup = build_setup(scenario, prepared.robot)
        plant, tau = assemble_plant(scenario, setup, prepared.q_start)
        super().__init__(plant, scenario.control.period, tau)
        self._outcome, self._start = outcome, self.q.copy()

    def write(self, command: RobotCommand) -> None:
        """Go on by one period, as told."""
        shares = np.abs(command.tau) / self.plant.robot.tau_max
        worst = float(shares.max()) if np.isfinite(shares).all() else np.inf
        self._outcome.share = max(self._outcome.share, worst)
        super().write(command)

    def _go_on(self, tau: Array, pushed: Array | None = None) -> None:
        super()._go_on(tau, pushed)
        if self.plant.robot.nv_base == 6:
            moved = pin.difference(self.plant.robot.model, self._start, self.q)
            self._outcome.tilt = max(self._outcome.tilt, float(np.linalg.norm(moved[3:6])))
            self._outcome.lowered = max(self._outcome.lowered, float(self._start[2] - self.q[2]))


def rehearse(
    scenario: schema.Scenario,
    prepared: Prepared,
    tried: Rehearsed,
    *,
    lockstep: bool,
    see: See | None = None,
) -> Outcome:
    """Run a scenario over a virtual network; the computing itself takes no time there.

    `see` is told every tick of the loop. What is killed says nothing more. The robot is watched for
    a moment after the session.
    Raises: nothing that happens on the wire; `ScenarioError`, `InputError`.
    """
    outcome, network = Outcome(), VirtualNetwork(tried.faults, tried.seed)
    robot = WatchedRobot(outcome, scenario, prepared)
    settings = FarEndSettings(lockstep, patience=1.0, watched=WATCHED)
    model = WireModel.of(
        robot.plant.robot, robot.plant.contacts, scenario.control.period, lockstep=lockstep
    )
    far_end = FarEnd(robot, UdpServer(model, network.place(ROBOT), settings.oldest), settings)
    every = 1e-4 if lockstep else scenario.control.period

    def act(now: float) -> float | None:
        if far_end.ended or (tried.killed == "robot" and robot.t >= tried.at):
            return None
        far_end.tick()
        return now + every

    network.start(act)
    run = RemoteRun(
        scenario,
        lambda _, model: UdpRobot(model, network.place(LOOP), ROBOT),
        lockstep=lockstep,
        prepared=prepared,
        clock=lambda: network.now,
    )
    ticks = cast("Generator[tuple[float, TickRecord], None, None]", run.ticks())
    try:
        for t, record in ticks:
            outcome.ticks += 1
            if see is not None:
                see(t, record)
            if tried.killed == "loop" and t >= tried.at:
                outcome.ended = "the loop was killed"
                run.link = _Gone()  # says no farewell
                break
    except RobotLostError as error:
        outcome.ended = str(error)
    ticks.close()
    network.run(network.now + AFTER, lambda: far_end.ended)
    outcome.told = list(run.story)
    outcome.fastest = far_end.aftermath.fastest_base
    return outcome


class _Gone:
    """What is left of a loop that was killed."""

    def read(self, timeout: float) -> None:
        """Hear nothing."""

    def write(self, command: RobotCommand) -> None:
        """Say nothing."""

    def close(self) -> None:
        """Say nothing."""
