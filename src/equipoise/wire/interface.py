"""What a robot offers to a loop, wherever it is: read, write, close."""

from __future__ import annotations

from collections import Counter
from enum import IntEnum
from typing import Any, NamedTuple, Protocol

import numpy as np

from equipoise.errors import EquipoiseError
from equipoise.spatial import Array
from equipoise.wire.health import NOTHING_SAID, Health

PARTS = ("base", "joints", "forces", "torque")  # of a state, each with an age of its own


class RobotMode(IntEnum):
    """What a robot does, as it says itself."""

    WAITING = 0  # is held where it starts: no command has come yet
    DRIVEN = 1  # gives the torque that it is told
    HELD = 2  # heard nothing, or was told so: holds its posture by its own servos, for good
    SUNK = 3  # could not be held: lets its weight down, braking
    ENDED = 4  # nothing happens any more


class CommandMode(IntEnum):
    """What a robot is asked to do."""

    TORQUE = 0  # give the torque
    HOLD = 1  # hold the posture of the moment without being told anything more
    POSTURE = 2  # before any torque: go to a posture by its own servos, and stay there


COMMAND_MODES, ROBOT_MODES = frozenset(CommandMode), frozenset(RobotMode)


class RobotState(NamedTuple):
    """What a robot says of itself.

    `sequence` counts the messages of its sender from 1, `t` [s] is the robot's own time. `q` (nq,),
    `v` (nv,), `lam` (r,) the multipliers of all contacts, `tau` (na,) [N m] the torque given in the
    step before; NaN where a sensor says nothing. `stamps` (4,) [s], in the order of `PARTS`: when
    each was heard last and whole, on the clock of `t`; -inf where it never was. `imu` (10,), empty
    where there is none: quaternion x, y, z, w of the base, its angular velocity [rad/s] and its
    acceleration less gravity [m/s^2], both in base axes. `health` of its motors is empty where
    nothing is said.
    """

    sequence: int
    t: float
    mode: RobotMode
    stamps: Array
    q: Array
    v: Array
    lam: Array
    tau: Array
    imu: Array = np.zeros(0)
    health: Health = NOTHING_SAID

    @property
    def ages(self) -> dict[str, float]:
        """Age [s] of every part at time `t`; infinite for what was never measured."""
        return {name: self.t - float(at) for name, at in zip(PARTS, self.stamps, strict=True)}


class RobotCommand(NamedTuple):
    """What a robot is told: `tau` (na,) [N m], in answer to the state of time `t` [s].

    `posture` (na,) [rad] of the joints counts in the mode of that name alone.
    """

    t: float
    mode: CommandMode
    tau: Array
    posture: Array = np.zeros(0)


class RobotLostError(EquipoiseError):
    """A robot that is not there, refuses, has let go by itself, is not fit, or went silent."""


class RobotInterface(Protocol):
    """A robot as a control loop sees it: simulated, in another process, or of steel."""

    def read(self, timeout: float) -> RobotState | None:
        """Return the newest state not read before, waiting for it `timeout` [s] at most.

        None if there is none. Never raises on what arrives: what is no good is counted.
        Raises: `RobotLostError` if the robot says that it will not be driven from here.
        """

    def write(self, command: RobotCommand) -> None:
        """Give a command. It acts from when the robot takes it; nothing is confirmed.

        Raises: `InputError` for a torque that is not finite, not of the right size, or beyond the
        limits: that is a fault of the caller, and nothing is given.
        """

    def close(self) -> None:
        """Let go of the robot: one that was commanded is told to hold. Twice does no harm."""


class RobotServer(Protocol):
    """The robot's side of a wire: takes commands, sends states."""

    dropped: Counter[Any]

    def now(self) -> float:
        """Return the time [s] on a clock that only goes forward."""

    def wait(self, until: float) -> None:
        """Return once something has arrived, or at the time `until` [s]."""

    def receive(self, t: float) -> RobotCommand | None:
        """Return the newest good command that has arrived by the robot's time `t` [s]."""

    def send(self, state: RobotState) -> RobotState:
        """Send a state; return it with its sequence number."""

    def close(self) -> None:
        """Take nothing any more."""


class Stamps:
    """Notes when each part of a robot's state was heard last."""

    def __init__(self, nq_base: int, nv_base: int) -> None:
        self._nq, self._nv = nq_base, nv_base
        self._at: Array = np.full(len(PARTS), -np.inf)

    def note(self, t: float, q: Array, v: Array, lam: Array) -> Array:
        """Return the stamps (4,) [s] with a reading that is heard at `t`, torque with it.

        A part in which anything is missing keeps its stamp.
        """
        parts = ((q[: self._nq], v[: self._nv]), (q[self._nq :], v[self._nv :]), (lam,))
        for k, arrays in enumerate(parts):
            if all(bool(np.isfinite(array).all()) for array in arrays):
                self._at[k] = t
        self._at[3] = t
        return self._at.copy()
