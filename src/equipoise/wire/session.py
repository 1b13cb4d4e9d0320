"""Sessions with a robot, written down as they were read, and read again as if from the robot."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from time import monotonic

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
from equipoise.wire.session_file import SessionWriter, read_session

FLUSH_PERIOD = 0.03  # [s] after which what was said is on the disk


class RecordingRobot:
    """A `RobotInterface` that passes everything on and writes it to `path` while it goes on.

    A program that is killed loses a few hundredths of a second of it. `digest` says which robot and
    contacts it is of. A disk that refuses ends the recording, not the run: `trouble` says so.
    Raises: `InputError` at once if there is no such folder, or such a file.
    """

    def __init__(
        self,
        behind: RobotInterface,
        path: Path,
        digest: bytes,
        clock: Callable[[], float] = monotonic,
    ) -> None:
        self.behind, self.path, self.trouble = behind, path, ""
        self._file: SessionWriter | None = SessionWriter(path, digest)
        self._clock, self._flushed = clock, clock()

    def read(self, timeout: float) -> RobotState | None:
        """Return the newest state not read before; see `RobotInterface`."""
        state = self.behind.read(timeout)
        if state is not None and self._file is not None:
            self._try(lambda file: file.note_state(state))
        return state

    def write(self, command: RobotCommand) -> None:
        """Give a command, and then write to the disk if it is time; see `RobotInterface`."""
        self.behind.write(command)
        if command.mode is CommandMode.TORQUE and self._file is not None:
            self._try(lambda file: file.note_command(command))
        now = self._clock()
        if now - self._flushed >= FLUSH_PERIOD:
            self._flushed = now
            self._try(SessionWriter.flush)

    def close(self) -> None:
        """Let go of the robot, and complete the file; twice does no harm."""
        self.behind.close()
        self._try(SessionWriter.close)
        self._file = None

    def _try(self, what: Callable[[SessionWriter], None]) -> None:
        if self._file is None:
            return
        try:
            what(self._file)
        except OSError as error:
            self.trouble = f"the session {self.path} is not whole: {error.strerror}"
            self._file = None


class SessionRobot:
    """A `RobotInterface` that says what a robot said in a session; what it is told moves nothing.

    `damage` says in words what is wrong with the end of the file, empty if nothing is. `apart`
    [N m] is how far commands were from those of the session at most, on the same states, `compared`
    of how many of them. Raises: `InputError` for a file of something else.
    """

    def __init__(self, path: Path, digest: bytes) -> None:
        content = read_session(path)
        if content.digest != digest:
            raise InputError(
                "the session is of another robot, other contacts or another period",
                given=str(path),
                remedy="Name the scenario, robot and values that it was recorded with",
            )
        self.damage = content.damage
        self._states = [row for chunk in content.chunks for row in chunk.states]
        self._given: dict[float, Array] = {
            float(row["t"]): row["tau"] for chunk in content.chunks for row in chunk.commands
        }
        self._next, self.apart, self.compared = 0, 0.0, 0

    @property
    def measures_base(self) -> bool:
        """Whether the robot ever said where its base was."""
        return any(np.isfinite(row["stamps"][0]) for row in self._states)

    def read(self, timeout: float) -> RobotState:
        """Return the next state at once. Raises: `RobotLostError` after the last one."""
        if self._next == len(self._states):
            raise RobotLostError(f"The session is over, t = {self._states[-1]['t']:.3f} s.")
        row = self._states[self._next]
        self._next += 1
        health = Health(row["temperature"], row["voltage"], row["words"], bool(row["stop"]))
        return RobotState(
            int(row["sequence"]), float(row["t"]), RobotMode(int(row["mode"])),
            row["stamps"], row["q"], row["v"], row["lam"], row["tau"], row["imu"], health,
        )  # fmt: skip

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
