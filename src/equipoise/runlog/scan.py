"""What is where in a log file, found without reading its chunks and without trusting it."""

from __future__ import annotations

import os
import struct
import zlib
from contextlib import suppress
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Metadata, Statistics
from mcap.stream_reader import CRCValidationError, get_chunk_data_stream

from equipoise.errors import RunLogError
from equipoise.runlog.layout import CHANNEL_ID, MAGIC, TOPIC

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

    channel: int
    ticks: int
    first: float
    last: float


@dataclass
class Scan:
    """What a log file holds.

    `complete` if it ends as it should; `closed` if its last bytes are those of a finished log.
    `pictures`: chunks without a tick, of what was added for other programs.
    `lost`: chunks of which only the index is left. `messages`: how many ticks the log says were
    written, None if it does not say. `topics`: what each number of a channel is said to be.
    """

    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    chunks: list[ChunkPlace] = field(default_factory=list)
    pictures: list[ChunkPlace] = field(default_factory=list)
    lost: list[LostChunk] = field(default_factory=list)
    messages: int | None = None
    topics: dict[int, set[str]] = field(default_factory=dict)
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
    found = _Found()
    while offset + _HEAD.size <= size:
        stream.seek(offset)
        opcode, length = _HEAD.unpack(stream.read(_HEAD.size))
        offset += _HEAD.size
        if opcode == 0 or offset + length > size:
            break
        if opcode == Opcode.METADATA:
            metadata = _read_metadata(stream.read(length), path)
            scan.metadata[metadata.name] = metadata.metadata
        elif opcode == Opcode.CHANNEL:
            _note_topic(scan, stream.read(length))
        elif opcode == Opcode.CHUNK and length >= _TIMES.size:
            first, last = _TIMES.unpack(stream.read(_TIMES.size))
            found.add_chunk(ChunkPlace(offset, length, first * 1e-9, last * 1e-9))
        elif opcode == Opcode.MESSAGE_INDEX:
            found.add_index(stream.read(length))
        elif opcode == Opcode.STATISTICS:
            found.statistics = stream.read(length)
        elif opcode == Opcode.FOOTER:
            stream.seek(offset + length)
            scan.complete = stream.read() == MAGIC
            break
        offset += length
    found.sort_into(scan)
    return scan


class _Found:
    """Chunks with the channels in their indexes, in the order of the file."""

    def __init__(self) -> None:
        self.chunks: list[tuple[ChunkPlace, set[int]]] = []
        self.lost: list[LostChunk] = []
        self.statistics = b""
        self._indexed: set[int] | None = None  # channels indexed since the last chunk

    def add_chunk(self, place: ChunkPlace) -> None:
        self._indexed = set()
        self.chunks.append((place, self._indexed))

    def add_index(self, content: bytes) -> None:
        """Note a channel of the last chunk, or a chunk that is gone."""
        if len(content) < _INDEX_HEAD.size:
            return
        channel, _ = _INDEX_HEAD.unpack_from(content)
        if self._indexed is not None and channel not in self._indexed:
            self._indexed.add(channel)
        elif (lost := _lost_chunk(content)) is not None:
            self.lost.append(lost)

    def sort_into(self, scan: Scan) -> None:
        """Tell ticks from pictures; what is not known to be a picture may hold ticks."""
        others = {number for number, topics in scan.topics.items() if TOPIC not in topics}
        for place, channels in self.chunks:
            pictures = bool(channels) and channels <= others
            (scan.pictures if pictures else scan.chunks).append(place)
        scan.lost = [lost for lost in self.lost if lost.channel not in others]
        scan.messages = _ticks_written(self.statistics, scan.topics)


def _note_topic(scan: Scan, content: bytes) -> None:
    with suppress(*_UNREADABLE):
        channel = Channel.read(ReadDataStream(BytesIO(content)))
        scan.topics.setdefault(channel.id, set()).add(channel.topic)


def _ticks_written(statistics: bytes, topics: dict[int, set[str]]) -> int | None:
    """Return how many ticks were written by the log's statistics, None if they cannot be read."""
    try:
        counts = Statistics.read(ReadDataStream(BytesIO(statistics))).channel_message_counts
    except _UNREADABLE:
        return None
    ids = [number for number in counts if TOPIC in topics.get(number, ())] or [CHANNEL_ID]
    return sum(counts.get(number, 0) for number in ids)


def _lost_chunk(index: bytes) -> LostChunk | None:
    """Return the chunk that an index without one stands for, None if it is none of ours."""
    if len(index) < _INDEX_HEAD.size + _ENTRY.size:
        return None
    channel, size = _INDEX_HEAD.unpack_from(index)
    ticks = min(size, len(index) - _INDEX_HEAD.size) // _ENTRY.size
    if ticks == 0:
        return None
    first, _ = _ENTRY.unpack_from(index, _INDEX_HEAD.size)
    last, _ = _ENTRY.unpack_from(index, _INDEX_HEAD.size + (ticks - 1) * _ENTRY.size)
    return LostChunk(channel, ticks, first * 1e-9, last * 1e-9)


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
