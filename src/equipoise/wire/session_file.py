"""The file of a session, written in chunks while it goes on: a killed program loses a few ticks.

`EQPS`, a byte 1 for the version, three zero bytes, the digest (16). Then chunks: `CHNK`, the size
of what follows the checksum, the CRC-32 of that; in it numbers of states and commands, sizes of
the parts in the order of `PARTS`, and, compressed by zstd, the states and then the commands. A
session that was closed ends with `OVER`. All numbers are little-endian, of 4 bytes in heads, of 2
for the sizes of parts, and of 8 bytes in states and commands.
"""

from __future__ import annotations

import struct
import zlib
from pathlib import Path
from typing import NamedTuple

import numpy as np
import zstandard

from equipoise.errors import InputError
from equipoise.wire.interface import ROBOT_MODES, RobotCommand, RobotState

HEAD = struct.Struct("<4sB3x16s")
CHUNK = struct.Struct("<4sII")
CONTENT = struct.Struct("<II9H")
BEGIN, PART, OVER = b"EQPS", b"CHNK", b"OVER"
VERSION = 1
COMPRESSION = 1  # of zstd: a tenth of a millisecond for a chunk
ROWS = 64  # states in a chunk at most
LONGEST = 1 << 26  # bytes of a chunk that are believed

PARTS = ("stamps", "q", "v", "lam", "tau", "imu", "temperature", "voltage", "words")
Sizes = tuple[int, ...]


def state_record(sizes: Sizes) -> np.dtype:
    """Return the fields of a state whose parts have these sizes."""
    kinds = ("<i8" if name == "words" else "<f8" for name in PARTS)
    parts = [(name, kind, (size,)) for name, kind, size in zip(PARTS, kinds, sizes, strict=True)]
    return np.dtype([("sequence", "<i8"), ("t", "<f8"), ("mode", "<i8"), ("stop", "<i8"), *parts])


def command_record(sizes: Sizes) -> np.dtype:
    """Return the fields of a torque: the time [s] of the state that it answers, and itself."""
    return np.dtype([("t", "<f8"), ("tau", "<f8", (sizes[PARTS.index("tau")],))])


class SessionWriter:
    """Writes states and commands to a file that does not exist yet.

    Raises: `InputError` if there is no such folder, or such a file is there already.
    """

    def __init__(self, path: Path, digest: bytes) -> None:
        if not path.parent.is_dir():
            raise InputError("there is no such folder for the session", given=str(path.parent))
        if path.exists():
            raise InputError(
                "there is such a session already", given=str(path), remedy="Choose another name"
            )
        self._path, self._digest = path, digest
        self._sizes: Sizes = ()
        self._states: np.ndarray = np.zeros(0)
        self._commands: np.ndarray = np.zeros(0)
        self._counts = [0, 0]
        self._compressor = zstandard.ZstdCompressor(level=COMPRESSION)
        self._end = 0  # bytes of whole chunks

    def note_state(self, state: RobotState) -> None:
        """Take a state into the chunk. Raises: `OSError` where a full chunk cannot be written."""
        health = state.health
        motors = health.temperature, health.voltage, health.words
        parts = state.stamps, state.q, state.v, state.lam, state.tau, state.imu, *motors
        sizes = tuple(len(part) for part in parts)
        if sizes != self._sizes or self._counts[0] == ROWS:
            self._begin(sizes)
        row = self._states[self._counts[0]]
        row["sequence"], row["t"] = state.sequence, state.t
        row["mode"], row["stop"] = state.mode, health.stop
        for name, part in zip(PARTS, parts, strict=True):
            row[name] = part
        self._counts[0] += 1

    def note_command(self, command: RobotCommand) -> None:
        """Take a torque into the chunk. Raises: `OSError`, as above."""
        if not self._sizes:
            return
        if self._counts[1] == ROWS:
            self._begin(self._sizes)
        row = self._commands[self._counts[1]]
        row["t"], row["tau"] = command.t, command.tau
        self._counts[1] += 1

    def _begin(self, sizes: Sizes) -> None:
        self.flush()
        if sizes != self._sizes:
            self._sizes = sizes
            self._states = np.zeros(ROWS, state_record(sizes))
            self._commands = np.zeros(ROWS, command_record(sizes))

    def flush(self) -> None:
        """Hand the chunk to the operating system. Raises: `OSError`."""
        states, commands = self._counts
        if not states and not commands:
            return
        rows = self._states[:states].tobytes() + self._commands[:commands].tobytes()
        content = CONTENT.pack(states, commands, *self._sizes) + self._compressor.compress(rows)
        self._append(CHUNK.pack(PART, len(content), zlib.crc32(content)) + content)
        self._counts = [0, 0]

    def close(self) -> None:
        """Write what is left, and that the session is whole; nothing if nothing was said.

        Raises: `OSError`.
        """
        self.flush()
        if self._end:
            self._append(CHUNK.pack(OVER, 0, 0))

    def _append(self, block: bytes) -> None:
        """Write at the end of the last whole chunk: one that was cut short is written over."""
        begun = self._end > 0
        if not begun:
            block = HEAD.pack(BEGIN, VERSION, self._digest) + block
        with self._path.open("r+b" if begun else "xb") as out:
            out.seek(self._end)
            out.write(block)
        self._end += len(block)


class Chunk(NamedTuple):
    """Some states and commands of a session, as records."""

    states: np.ndarray
    commands: np.ndarray


class SessionContent(NamedTuple):
    """What a file holds: its digest, its whole chunks, and in words what is wrong with its end."""

    digest: bytes
    chunks: list[Chunk]
    damage: str


def read_session(path: Path) -> SessionContent:
    """Read a session, to the first byte that is not right.

    Raises: `InputError` for a file of something else, or without a state.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise _no_session(path, str(error.strerror)) from None
    if len(content) < HEAD.size or content[:4] != BEGIN:
        raise _no_session(path, "it begins otherwise")
    _, version, digest = HEAD.unpack_from(content)
    if version != VERSION:
        raise _no_session(path, f"it has version {version}, {VERSION} is read here")
    chunks: list[Chunk] = []
    at, over = HEAD.size, False
    while not over:
        found = _chunk(content, at)
        if found is None:
            break
        chunk, at = found
        over = chunk is None
        if chunk is not None:
            chunks.append(chunk)
    if not any(len(chunk.states) for chunk in chunks):
        raise _no_session(path, "no state in it is whole")
    return SessionContent(digest, chunks, _damage(chunks, len(content) - at, over))


def _chunk(content: bytes, at: int) -> tuple[Chunk | None, int] | None:
    """Return a chunk, None for the end mark, and where the next begins; None where it is broken."""
    if len(content) < at + CHUNK.size:
        return None
    name, size, crc = CHUNK.unpack_from(content, at)
    begin = at + CHUNK.size
    body = content[begin : begin + size]
    if name == OVER and size == crc == 0:
        return None, begin
    if name != PART or not CONTENT.size <= size == len(body) or zlib.crc32(body) != crc:
        return None
    states, commands, *sizes = CONTENT.unpack_from(body)
    kinds = state_record(tuple(sizes)), command_record(tuple(sizes))
    expected = states * kinds[0].itemsize + commands * kinds[1].itemsize
    if expected > LONGEST:
        return None
    packed = body[CONTENT.size :]
    try:
        if zstandard.frame_content_size(packed) != expected:
            return None
        rows = zstandard.ZstdDecompressor().decompress(packed)
    except zstandard.ZstdError:
        return None
    cut = states * kinds[0].itemsize
    chunk = Chunk(np.frombuffer(rows[:cut], kinds[0]), np.frombuffer(rows[cut:], kinds[1]))
    whole = np.isin(chunk.states["mode"], list(ROBOT_MODES)).all()
    return (chunk, begin + size) if whole else None


def _damage(chunks: list[Chunk], left: int, over: bool) -> str:
    """Return what is wrong with the end of a session, empty if nothing is."""
    last = next(chunk for chunk in reversed(chunks) if len(chunk.states)).states["t"][-1]
    if over and not left:
        return ""
    if left:
        return f"the session is damaged after t = {last:.3f} s: {left} bytes were left out"
    return f"the session was not closed: it breaks off after t = {last:.3f} s"


def _no_session(path: Path, why: str) -> InputError:
    return InputError(
        f"{path} is no session: {why}",
        remedy="equipoise control SCENARIO --record FILE writes one",
    )
