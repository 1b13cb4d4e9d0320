"""When the loop ticks: once for every state in lockstep, or in time with a robot that runs."""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic
from typing import NamedTuple, Protocol

from equipoise.wire.interface import (
    RobotCommand,
    RobotInterface,
    RobotLostError,
    RobotMode,
    RobotState,
)

RESEND = 0.02  # [s] after which a command is sent again in lockstep
SLACK = 0.005  # [s] after its time that a state is waited for
LOST = 1.0  # [s] without any state after which a robot that runs is taken for lost
PATIENCE = 10.0  # [s] the same in lockstep, where nothing hurries

Clock = Callable[[], float]


class Due(NamedTuple):
    """The tick that is due: its number, and the state for it, None if none has come."""

    tick: int
    state: RobotState | None


class Pace(Protocol):
    """Waits for the tick after the one that was answered last."""

    def next(self, tick: int, answer: RobotCommand) -> Due:
        """Return what is due after `tick`, which was answered by `answer`.

        Raises: `RobotLostError`.
        """


def require_driven(state: RobotState) -> None:
    """Refuse to go on with a robot that has let go by itself. Raises: `RobotLostError`."""
    if state.mode not in (RobotMode.WAITING, RobotMode.DRIVEN):
        raise RobotLostError(f"The robot holds itself, t = {state.t:.3f} s: it was not driven.")


class Lockstep:
    """The robot's time waits for its command: what is lost is sent again, nothing is skipped."""

    def __init__(
        self,
        robot: RobotInterface,
        dt: float,
        clock: Clock = monotonic,
        *,
        patience: float = PATIENCE,
    ) -> None:
        self._robot, self._dt, self._clock, self._patience = robot, dt, clock, patience

    def next(self, tick: int, answer: RobotCommand) -> Due:
        """Return the next state; answer again as long as the robot asks again or says nothing."""
        heard = self._clock()
        while self._clock() - heard <= self._patience:
            state = self._robot.read(RESEND)
            if state is not None:
                heard = self._clock()
                require_driven(state)
                number = round(state.t / self._dt)
                if number > tick:
                    return Due(number, state)
            self._robot.write(answer)
        raise RobotLostError(f"The robot has said nothing for {self._patience:g} s.")


class RealTime:
    """The robot's time runs: a tick is due when its state comes, or a little after its time.

    Its time is that of the last state that came in time, and whole periods since. A state that
    comes after its tick is given to the next one: it is late, and better than none. A robot whose
    time is behind is waited for, a period more with every tick that gets a late state.
    """

    def __init__(self, robot: RobotInterface, dt: float, clock: Clock = monotonic) -> None:
        self._robot, self._dt, self._clock = robot, dt, clock
        self._origin: float | None = None  # when tick 0 was due, by what came in time
        self._heard = 0.0
        self._beginning = Lockstep(robot, dt, clock, patience=LOST)
        self.missed = self.skipped = 0  # ticks without a state; ticks that were over already

    def next(self, tick: int, answer: RobotCommand) -> Due:
        """Return the next tick and the newest state that has come by then."""
        if self._origin is None:  # nothing moves yet, and how long the wire is will show
            return self._in_time(self._beginning.next(tick, answer), tick)
        due, late = self._origin + (tick + 1) * self._dt + SLACK, None
        while True:
            state = self._robot.read(max(due - self._clock(), 0.0))
            now = self._clock()
            if state is None:
                break
            self._heard = now
            require_driven(state)
            number = round(state.t / self._dt)
            if number > tick:
                return self._in_time(Due(number, state), tick)
            late = state
        if now - self._heard >= LOST:
            raise RobotLostError(f"The robot has said nothing for {now - self._heard:.1f} s.")
        self.missed += 1
        if late is not None:
            self._origin += self._dt
        return Due(tick + 1, late)

    def _in_time(self, due: Due, before: int) -> Due:
        """Note a state that has come in time, and what was skipped for it."""
        self._heard = self._clock()
        self._origin = self._heard - due.tick * self._dt
        self.skipped += due.tick - before - 1
        return due
