"""The far end: a simulated robot that is served on a wire, and is safe without a commander."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from equipoise.errors import InputError
from equipoise.physics import DivergedError
from equipoise.simulation.simulated_robot import SimulatedRobot
from equipoise.wire.interface import (
    CommandMode,
    RobotCommand,
    RobotMode,
    RobotServer,
    RobotState,
)

RESEND = 0.02  # [s] after which a state that nobody answered is sent again, in lockstep


@dataclass(frozen=True)
class FarEndSettings:
    """How the far end goes on.

    In `lockstep` its time waits for the command that answers its state, `patience` [s] of the
    machine's clock at most. Else its time goes on by itself, with the newest command.
    `silence` [s], of its own time, after which it is on its own; it then goes on for `watched` [s]
    before its end.
    """

    lockstep: bool
    silence: float = 0.02
    patience: float = 10.0
    watched: float = 3.0

    def __post_init__(self) -> None:
        for name in ("silence", "patience", "watched"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0.0):
                raise InputError(f"{name} must be finite and positive", given=value)

    @property
    def oldest(self) -> float:
        """The age [s] of the state that a command may answer."""
        return 0.0 if self.lockstep else self.silence


@dataclass
class Aftermath:
    """What the robot did since it was on its own: speeds [m/s], [rad/s], how far down [m]."""

    fastest_base: float = 0.0
    fastest_joint: float = 0.0
    lowered: float = 0.0
    ended: RobotMode = RobotMode.ENDED


class FarEnd:
    """Serves a robot: obeys the commander, lets the robot hold itself without one.

    `tick` never waits. `cause` says in words why the robot is on its own or has ended.
    """

    def __init__(
        self, robot: SimulatedRobot, server: RobotServer, settings: FarEndSettings
    ) -> None:
        self.robot, self.server, self.settings = robot, server, settings
        self.cause = ""
        self.interrupted = False  # whether somebody at its own end asked for that
        self.aftermath = Aftermath()
        self._now: Callable[[], float] = server.now
        self._heard, self._heard_wall = 0.0, self._now()
        self._sent_wall = -np.inf
        self._command: RobotCommand | None = None  # the newest, in real time
        self._alone_at = np.inf
        self._height = 0.0  # of the base when it was left alone
        self._state: RobotState | None = robot.read(0.0)

    @property
    def ended(self) -> bool:
        """Whether nothing happens any more."""
        return self.robot.mode is RobotMode.ENDED

    @property
    def alone(self) -> bool:
        """Whether the robot is on its own."""
        return self._alone_at < np.inf

    def tick(self) -> None:
        """Take what has arrived and go on by a period, where one is due."""
        if self.ended:
            return
        robot = self.robot
        command = self.server.receive(robot.t)
        if command is not None:
            self._heard, self._heard_wall = robot.t, self._now()
            if command.mode is CommandMode.HOLD and not self.alone:
                self._leave("the commander said so")
        if self.alone:
            self._hold()
        elif self.settings.lockstep:
            self._answer(command)
        else:
            self._go_on(command)

    def leave(self, cause: str) -> None:
        """Let the robot be on its own, asked for at its own end; one that only waits ends."""
        if self.ended or self.alone:
            return
        self.interrupted = True
        if self.robot.mode is RobotMode.WAITING:
            self._end(cause)
        else:
            self._leave(cause)

    # -- going on -------------------------------------------------------------------------------

    def _answer(self, command: RobotCommand | None) -> None:
        """Go on if the state was answered; say it again if that takes long."""
        if command is not None and command.mode is not CommandMode.HOLD:
            self._advance(command)
            self._send()
        elif self._now() - self._sent_wall >= RESEND:
            self._send()
        waited = self._now() - self._heard_wall
        if self.robot.mode is RobotMode.DRIVEN and waited > self.settings.patience:
            self._leave(f"nothing was heard for {waited:.1f} s")

    def _go_on(self, command: RobotCommand | None) -> None:
        """Go on by a period with the newest command, unless none has come yet."""
        last = self._command
        driven = last is not None and last.mode is CommandMode.TORQUE
        if command is not None and not (driven and command.mode is CommandMode.POSTURE):
            self._command = command
        if self._command is None:
            self._send()  # waits where it starts
            return
        if self._command.mode is CommandMode.POSTURE:  # its servos need nobody
            self._heard = self.robot.t
        silent = self.robot.t - self._heard
        if silent > self.settings.silence:
            self._leave(f"nothing was heard for {1e3 * silent:.0f} ms")
            self._hold()
            return
        self._advance(self._command)
        self._send()

    def _advance(self, command: RobotCommand) -> None:
        """Obey a command for a period, and in lockstep for every tick that is missed."""
        try:
            self.robot.write(command)
            fresh = self.robot.read(0.0)
            while fresh is None and self.settings.lockstep:
                self.robot.write(command)
                fresh = self.robot.read(0.0)
        except DivergedError as error:
            self._end(str(error))
            return
        self._state = fresh

    def _send(self) -> None:
        """Send the newest state, if there is one that is to be seen."""
        if self._state is not None:
            self.server.send(self._state._replace(mode=self.robot.mode))
            self._sent_wall = self._now()

    # -- and holding ---------------------------------------------------------------------------

    def _leave(self, cause: str) -> None:
        self.cause = f"t = {self.robot.t:.3f} s: on its own: {cause}"
        self._alone_at = self.robot.t
        self._height = float(self.robot.q[2]) if self.robot.plant.robot.nv_base == 6 else 0.0

    def _hold(self) -> None:
        """Go on by a period by the robot's own servos; note how it goes."""
        if self.ended:
            return
        try:
            self.robot.hold()
            state = self.robot.read(0.0)
        except DivergedError as error:
            self._end(str(error))
            return
        if state is not None:
            self._state = state
            self._send()
        nv, v, after = self.robot.plant.robot.nv_base, self.robot.v, self.aftermath
        if nv == 6:
            after.fastest_base = max(after.fastest_base, float(np.linalg.norm(v[:3])))
            after.lowered = self._height - float(self.robot.q[2])
        after.fastest_joint = max(after.fastest_joint, float(np.abs(v[nv:]).max()))
        if self.robot.t - self._alone_at >= self.settings.watched:
            self.aftermath.ended = self.robot.mode
            self.robot.mode = RobotMode.ENDED
            self._send()

    def _end(self, cause: str) -> None:
        self.cause = f"t = {self.robot.t:.3f} s: {cause}"
        self.robot.mode = RobotMode.ENDED
        self._send()
