"""Sessions with a robot, written down as they were read, and read again as if from the robot."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from equipoise.errors import InputError
from equipoise.spatial import Array
from equipoise.wire.health import Health
from equipoise.wire.interface import (
    CommandMode,
    RobotCommand,
    RobotInterface,
    RobotLostError,
    RobotMode,
    RobotState,
)

STATE = ("sequence", "t", "mode", "stamps", "q", "v", "lam", "tau", "imu")
HEALTH = ("temperature", "voltage", "words", "stop")
COMMAND = ("answered", "command")  # time of the answered state [s], torque [N m]


class RecordingRobot:
    """A `RobotInterface` that passes everything on, and writes it to `path` when it is closed.

    An npz file: each field of all states in an array of its own, likewise of all torques that were
    commanded; `digest` says which robot and contacts it is of.
    Raises: `InputError` at once if there is no such folder.
    """

    def __init__(self, behind: RobotInterface, path: Path, digest: bytes) -> None:
        if not path.parent.is_dir():
            raise InputError("there is no such folder for the session", given=str(path.parent))
        self.behind, self.path, self._digest = behind, path, digest
        self._states: list[RobotState] = []
        self._commands: list[RobotCommand] = []

    def read(self, timeout: float) -> RobotState | None:
        """Return the newest state not read before; see `RobotInterface`."""
        state = self.behind.read(timeout)
        if state is not None:
            self._states.append(state)
        return state

    def write(self, command: RobotCommand) -> None:
        """Give a command; see `RobotInterface`."""
        self.behind.write(command)
        if command.mode is CommandMode.TORQUE:
            self._commands.append(command._replace(tau=np.array(command.tau)))

    def close(self) -> None:
        """Let go of the robot, and write down what was said; once."""
        self.behind.close()
        if not self._states:
            return
        states, commands = self._states, self._commands
        fields: dict[str, Any] = {
            name: np.array([getattr(one, name) for one in states]) for name in STATE
        }
        for name in HEALTH:
            fields[name] = np.array([getattr(one.health, name) for one in states])
        given = np.array([one.tau for one in commands]).reshape(-1, states[0].tau.size)
        fields["answered"], fields["command"] = np.array([one.t for one in commands]), given
        fields["digest"] = np.frombuffer(self._digest, np.uint8)
        with self.path.open("wb") as out:
            np.savez_compressed(out, **fields)
        self._states, self._commands = [], []


class SessionRobot:
    """A `RobotInterface` that says what a robot said in a session; what it is told moves nothing.

    `apart` [N m] is how far commands were from those of the session at most, on the same states,
    `compared` of how many of them. Raises: `InputError` for a file of something else.
    """

    def __init__(self, path: Path, digest: bytes) -> None:
        self._fields = fields = _read(path)
        if fields["digest"].tobytes() != digest:
            raise InputError(
                "the session is of another robot, other contacts or another period",
                given=str(path),
                remedy="Name the scenario, robot and values that it was recorded with",
            )
        self._given: dict[float, Array] = dict(
            zip(fields["answered"].tolist(), fields["command"], strict=True)
        )
        self._next, self.apart, self.compared = 0, 0.0, 0

    @property
    def measures_base(self) -> bool:
        """Whether the robot ever said where its base was."""
        return bool(np.isfinite(self._fields["stamps"][:, 0]).any())

    def read(self, timeout: float) -> RobotState:
        """Return the next state at once. Raises: `RobotLostError` after the last one."""
        k, fields = self._next, self._fields
        if k == len(fields["t"]):
            raise RobotLostError(f"The session is over, t = {fields['t'][-1]:.3f} s.")
        self._next += 1
        stamps, q, v, lam, tau, imu = (fields[name][k] for name in STATE[3:])
        temperature, voltage, words, stop = (fields[name][k] for name in HEALTH)
        health = Health(temperature, voltage, words, bool(stop))
        mode, number, t = RobotMode(int(fields["mode"][k])), fields["sequence"][k], fields["t"][k]
        return RobotState(int(number), float(t), mode, stamps, q, v, lam, tau, imu, health)

    def write(self, command: RobotCommand) -> None:
        """Compare a torque with the one of the session that answered the same state."""
        given = self._given.get(command.t)
        if command.mode is CommandMode.TORQUE and given is not None:
            self.apart = max(self.apart, float(np.abs(command.tau - given).max(initial=0.0)))
            self.compared += 1

    def close(self) -> None:
        """Let go: there is nothing to let go of."""

    def sentence(self) -> str:
        """Return in words how far the commands were from those of the session."""
        return (
            f"{self.compared} commands compared with those of the session: "
            f"{self.apart:.3g} N m apart at most"
        )


def _read(path: Path) -> dict[str, Array]:
    """Return the arrays of a session. Raises: `InputError`."""
    names = (*STATE, *HEALTH, *COMMAND, "digest")
    try:
        with path.open("rb") as stream, np.load(stream) as kept:
            fields = {name: kept[name] for name in names}
    except (OSError, ValueError, KeyError, TypeError, zipfile.BadZipFile) as error:
        raise InputError(
            f"{path} is no session: {error}",
            remedy="equipoise control SCENARIO --record FILE writes one",
        ) from None
    n, given = len(fields["t"]), len(fields["answered"])
    if (
        not n
        or any(len(fields[name]) != n for name in (*STATE, *HEALTH))
        or len(fields["command"]) != given
        or not np.isin(fields["mode"], list(RobotMode)).all()
    ):
        raise InputError(f"{path} is no session: its parts do not fit together")
    return fields
