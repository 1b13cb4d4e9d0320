"""A robot that is somewhere else is brought to where a scenario starts, slowly, by its servos."""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic

import numpy as np

from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.trajectories.minimum_jerk import FASTEST, step
from equipoise.wire.health import HOTTEST_AT_START, trouble
from equipoise.wire.interface import (
    CommandMode,
    RobotCommand,
    RobotInterface,
    RobotLostError,
    RobotMode,
    RobotState,
)

NEAR, FAR = 0.01, 1.0  # [rad] of a joint: what is left as it is, what is too far
SPEED = 0.3  # [rad/s] of the joint that has the longest way
SHORTEST, SETTLING, CORRECTING = 1.0, 1.0, 0.2  # [s]
ASTRAY = 0.3  # [rad] that a joint may be from where it is led
RESEND, SILENCE = 0.02, 1.0  # [s]


class BroughtUp:
    """A `RobotInterface` that brings the robot behind it to `joints` (na,) [rad] at the first read.

    Time is counted from there on: it is zero until the robot is given its first torque. `told` says
    what was done. Only a robot that waits, is fit, and has no joint farther than a radian is moved.
    """

    def __init__(
        self,
        behind: RobotInterface,
        robot: Robot,
        joints: Array,
        clock: Callable[[], float] = monotonic,
    ) -> None:
        self.behind, self.robot, self.told = behind, robot, ""
        self._joints, self._clock = np.array(joints), clock
        self._met = self._driven = self._started = False
        self._zero = 0.0  # of our time, on the robot's clock

    def read(self, timeout: float) -> RobotState | None:
        """Return the newest state not read before; see `RobotInterface`.

        Raises: `RobotLostError` if the robot does not follow its servos, or is not fit any more.
        """
        state = self.behind.read(timeout)
        if state is None:
            return None
        if not self._met:
            self._met = True
            state = self._brought(state)
        if not self._driven or (not self._started and self.told):
            self._zero = state.t if self.told else 0.0
            self._started = self._driven
        return state._replace(t=state.t - self._zero, stamps=state.stamps - self._zero)

    def write(self, command: RobotCommand) -> None:
        """Give a command; see `RobotInterface`."""
        self._driven = True
        self.behind.write(command._replace(t=command.t + self._zero))

    def close(self) -> None:
        """Let go of the robot."""
        self.behind.close()

    def _brought(self, state: RobotState) -> RobotState:
        """Return the state in which the robot is where it should be; at once if it is."""
        nq = self.robot.nq_base
        start = state.q[nq:].copy()
        way = self._joints - start
        farthest = int(np.argmax(np.abs(way)))
        length = float(np.abs(way[farthest]))
        ready = state.mode is RobotMode.WAITING and not self._unfit(state)
        if not (ready and NEAR < length <= FAR):
            return state
        began, takes = state.t, max(FASTEST * length / SPEED, SHORTEST)
        sag, last = np.zeros_like(way), state.t  # what servos leave under load is corrected
        while state.t - began < takes + SETTLING:
            posture = start + way * step(min((state.t - began) / takes, 1.0))
            state = self._led(state, posture + sag)
            sag += (posture - state.q[nq:]) * (state.t - last) / CORRECTING
            last = state.t
            off = np.abs(posture - state.q[nq:])
            if not (off <= ASTRAY).all():
                name = self.robot.joint_names[int(np.argmax(off))]
                raise RobotLostError(
                    f"The robot does not follow its servos: {name} is off by {off.max():.2f} rad."
                )
            if self._unfit(state):
                raise RobotLostError(f"The robot was let go: {self._unfit(state)}.")
        self.told = (
            f"it was brought there by its servos in {takes:.1f} s "
            f"({self.robot.joint_names[farthest]} by {length:.2f} rad)"
        )
        return state

    def _led(self, state: RobotState, posture: Array) -> RobotState:
        """Give a posture until a new state comes. Raises: `RobotLostError`."""
        command = RobotCommand(state.t, CommandMode.POSTURE, np.zeros(self.robot.na), posture)
        until = self._clock() + SILENCE
        while self._clock() < until:
            self.behind.write(command)
            new = self.behind.read(RESEND)
            if new is not None and new.t > state.t:
                return new
        raise RobotLostError(f"The robot has said nothing for {SILENCE:g} s.")

    def _unfit(self, state: RobotState) -> str:
        return trouble(state.health, self.robot.joint_names, HOTTEST_AT_START)
