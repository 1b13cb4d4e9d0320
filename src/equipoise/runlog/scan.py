"""What is where in a log file, found without reading its chunks and without trusting it."""

from __future__ import annotations

import os
import struct
import zlib
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Chunk, Metadata
from mcap.stream_reader import CRCValidationError, get_chunk_data_stream

from equipoise.errors import RunLogError
from equipoise.runlog.mcapfile import MAGIC

_HEAD = struct.Struct("<BQ")  # opcode and length of a record
_TIMES = struct.Struct("<QQ")  # how a chunk begins: time of its first and last message [ns]
_UNREADABLE = (
    McapError,
    CRCValidationError,
    struct.error,
    zstandard.ZstdError,
    zlib.error,
    ValueError,
    RuntimeError,
    MemoryError,
    OverflowError,
)


_INDEX_HEAD = struct.Struct("<HI")  # how a message index begins: channel, size of its entries
_ENTRY = struct.Struct("<QQ")  # one entry of it: time [ns] and place [bytes] of a message


@dataclass(frozen=True)
class ChunkPlace:
    """Where a chunk's content is [bytes] and which times it spans [s]."""

    offset: int
    length: int
    first: float
    last: float


@dataclass(frozen=True)
class LostChunk:
    """A chunk that is no longer recognised: its ticks, and from when to when [s] they were."""

    ticks: int
    first: float
    last: float


@dataclass
class Scan:
    """What a log file holds.

    `complete` if it ends as it should; `closed` if its last bytes are those of a finished log.
    `lost`: chunks of which only the index is left. `messages`: how many ticks the log says were
    written, None if it does not say.
    """

    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    chunks: list[ChunkPlace] = field(default_factory=list)
    lost: list[LostChunk] = field(default_factory=list)
    messages: int | None = None
    complete: bool = False
    closed: bool = False


def scan_log(stream: BinaryIO, path: Path) -> Scan:
    """Walk over the records of a log up to its end or to where it breaks off.

    Raises: RunLogError if the file is empty or no MCAP file.
    """
    size = os.fstat(stream.fileno()).st_size
    _check_magic(stream, size, path)
    scan, offset = Scan(), len(MAGIC)
    stream.seek(max(size - len(MAGIC), len(MAGIC)))
    scan.closed = stream.read() == MAGIC
    indexed = True  # whether the last chunk's index was seen
    while offset + _HEAD.size <= size:
        stream.seek(offset)
        opcode, length = _HEAD.unpack(stream.read(_HEAD.size))
        offset += _HEAD.size
        if opcode == 0 or offset + length > size:
            break
        if opcode == Opcode.METADATA:
            metadata = _read_metadata(stream.read(length), path)
            scan.metadata[metadata.name] = metadata.metadata
        elif opcode == Opcode.CHUNK and length >= _TIMES.size:
            first, last = _TIMES.unpack(stream.read(_TIMES.size))
            scan.chunks.append(ChunkPlace(offset, length, first * 1e-9, last * 1e-9))
            indexed = False
        elif opcode == Opcode.MESSAGE_INDEX:
            if indexed and (lost := _lost_chunk(stream.read(length))) is not None:
                scan.lost.append(lost)
            indexed = True
        elif opcode == Opcode.STATISTICS and length >= 8:
            scan.messages = int.from_bytes(stream.read(8), "little")
        elif opcode == Opcode.FOOTER:
            stream.seek(offset + length)
            scan.complete = stream.read() == MAGIC
            break
        offset += length
    return scan


def _lost_chunk(index: bytes) -> LostChunk | None:
    """Return the chunk that an index without one stands for, None if it is none of ours."""
    if len(index) < _INDEX_HEAD.size + _ENTRY.size:
        return None
    _, size = _INDEX_HEAD.unpack_from(index)
    ticks = min(size, len(index) - _INDEX_HEAD.size) // _ENTRY.size
    if ticks == 0:
        return None
    first, _ = _ENTRY.unpack_from(index, _INDEX_HEAD.size)
    last, _ = _ENTRY.unpack_from(index, _INDEX_HEAD.size + (ticks - 1) * _ENTRY.size)
    return LostChunk(ticks, first * 1e-9, last * 1e-9)


def read_chunk(stream: BinaryIO, place: ChunkPlace) -> bytes | None:
    """Return the messages of a chunk as they were written, or None if the chunk is damaged."""
    stream.seek(place.offset)
    try:
        chunk = Chunk.read(ReadDataStream(BytesIO(stream.read(place.length))))
        content, length = get_chunk_data_stream(chunk, validate_crc=True)
        return _without_definitions(content.read(length))
    except _UNREADABLE:
        return None


def _without_definitions(content: bytes) -> bytes:
    """Drop the schema and channel records that other tools put before the messages."""
    offset = 0
    while content[offset : offset + 1] in (b"\x03", b"\x04"):
        _, length = _HEAD.unpack_from(content, offset)
        offset += _HEAD.size + length
    return content[offset:] if offset else content


def _check_magic(stream: BinaryIO, size: int, path: Path) -> None:
    if size == 0:
        raise RunLogError(f"{path} is empty: the run ended before it began. Run it again.")
    start = stream.read(len(MAGIC))
    if start != MAGIC:
        if MAGIC.startswith(start):
            raise cut_off_early(path)
        raise RunLogError(
            f"{path} is not an MCAP file (it begins with {start!r}). "
            "Give a run's folder or the run.mcap in it."
        )


def _read_metadata(content: bytes, path: Path) -> Metadata:
    try:
        return Metadata.read(ReadDataStream(BytesIO(content)))
    except _UNREADABLE as error:
        raise RunLogError(f"{path} is damaged near its beginning: {error}.") from error


def cut_off_early(path: Path) -> RunLogError:
    """Say that a log ends before its channels are described."""
    return RunLogError(f"{path} breaks off within its first records: no tick of it can be read.")
