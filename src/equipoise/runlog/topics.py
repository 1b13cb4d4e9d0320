"""Topics added to a log that is done: what other programs draw, beside the ticks.

The ticks' bytes stay as they are; the file is written anew beside itself and then takes its own
place, so that whoever interrupts this finds the old log or the new one, whole.
"""

from __future__ import annotations

import os
import shutil
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import zstandard
from mcap.data_stream import RecordBuilder
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import (
    Channel,
    Chunk,
    ChunkIndex,
    McapRecord,
    Message,
    MessageIndex,
    MetadataIndex,
    Schema,
    Statistics,
)

from equipoise.errors import InputError, RunLogError
from equipoise.runlog.layout import TOPIC as TICKS
from equipoise.runlog.mcap_summary import ending

CHUNK_BYTES = 1 << 20
COMPRESSION_LEVEL = 6  # of zstd; pictures repeat themselves


@dataclass(frozen=True)
class Topic:
    """Messages of one kind: `schema` (a serialised FileDescriptorSet) describes `schema_name`.

    `messages` are (time [ns], bytes) in the order of time.
    """

    name: str
    schema_name: str
    schema: bytes
    messages: Sequence[tuple[int, bytes]]


@dataclass
class _Content:
    """What a log holds, as its summary says it."""

    statistics: Statistics
    schemas: list[Schema]
    channels: list[Channel]
    chunks: list[ChunkIndex]
    metadata: list[MetadataIndex]

    def groups(self) -> dict[Opcode, Sequence[McapRecord]]:
        """Return the records of the summary."""
        self.statistics.schema_count = len(self.schemas)
        self.statistics.channel_count = len(self.channels)
        self.statistics.chunk_count = len(self.chunks)
        self.statistics.message_count = sum(self.statistics.channel_message_counts.values())
        return {
            Opcode.SCHEMA: self.schemas,
            Opcode.CHANNEL: self.channels,
            Opcode.STATISTICS: [self.statistics],
            Opcode.CHUNK_INDEX: self.chunks,
            Opcode.METADATA_INDEX: self.metadata,
        }


def add_topics(path: Path, topics: Sequence[Topic]) -> None:
    """Add topics to a finished log; those that it has besides its ticks are replaced.

    Raises: InputError for a topic that is the ticks' own; RunLogError if the log is not whole or
    the disk refuses.
    """
    if any(topic.name == TICKS for topic in topics):
        raise InputError("this topic belongs to the ticks", given=TICKS)
    beside = path.with_name(path.name + ".part")
    try:
        content = _ticks_of(path)
        end = max(
            index.chunk_start_offset + index.chunk_length + index.message_index_length
            for index in content.chunks
        )
        with open(path, "rb") as source, open(beside, "wb") as stream:
            shutil.copyfileobj(source, stream, CHUNK_BYTES)
            stream.seek(end)
            stream.truncate()
            for topic in topics:
                for block in _added(topic, content, end):
                    end += stream.write(block)
            stream.write(ending(content.groups(), end))
        os.replace(beside, path)
    except OSError as error:
        raise RunLogError(f"Cannot add pictures to {path}: {error.strerror}.") from error
    finally:
        beside.unlink(missing_ok=True)


def _ticks_of(path: Path) -> _Content:
    """Return what the log holds, without what was added before."""
    refusal = f"{path} is not whole: nothing can be added to it."
    try:
        with open(path, "rb") as stream:
            summary = make_reader(stream).get_summary()
    except McapError as error:
        raise RunLogError(refusal) from error
    if summary is None or summary.statistics is None:
        raise RunLogError(refusal)
    mine = [channel for channel in summary.channels.values() if channel.topic == TICKS]
    if len(mine) != 1:
        raise RunLogError(f"{path} has no topic {TICKS}: it is not a log of Equipoise.")
    channel = mine[0]
    chunks = [one for one in summary.chunk_indexes if channel.id in one.message_index_offsets]
    if not chunks:
        raise RunLogError(f"{path} holds no tick: there is nothing to add pictures to.")
    count = summary.statistics.channel_message_counts[channel.id]
    return _Content(
        replace(summary.statistics, channel_message_counts={channel.id: count}),
        [summary.schemas[channel.schema_id]],
        [channel],
        chunks,
        summary.metadata_indexes,
    )


def _added(topic: Topic, content: _Content, at: int) -> Iterator[bytes]:
    """Yield the bytes of a topic, from byte `at` on, and note them in the content."""
    schema = Schema(
        id=content.schemas[-1].id + 1,
        data=topic.schema,
        encoding="protobuf",
        name=topic.schema_name,
    )
    channel = Channel(
        id=content.channels[-1].id + 1,
        topic=topic.name,
        message_encoding="protobuf",
        metadata={},
        schema_id=schema.id,
    )
    content.schemas.append(schema)
    content.channels.append(channel)
    content.statistics.channel_message_counts[channel.id] = len(topic.messages)
    head = _octets(schema) + _octets(channel)
    yield head
    at += len(head)
    for messages in _pieces(topic.messages):
        block, index = _chunk(channel.id, messages, at)
        content.chunks.append(index)
        yield block
        at += len(block)


def _pieces(messages: Sequence[tuple[int, bytes]]) -> Iterator[list[tuple[int, bytes]]]:
    piece: list[tuple[int, bytes]] = []
    size = 0
    for message in messages:
        piece.append(message)
        size += len(message[1])
        if size >= CHUNK_BYTES:
            yield piece
            piece, size = [], 0
    if piece:
        yield piece


def _chunk(channel: int, messages: list[tuple[int, bytes]], at: int) -> tuple[bytes, ChunkIndex]:
    """Return the bytes of a chunk with its index, and what the summary says of it."""
    builder = RecordBuilder()
    entries = []
    for k, (time, content) in enumerate(messages):
        entries.append((time, builder.count))
        Message(
            channel_id=channel, log_time=time, data=content, publish_time=time, sequence=k
        ).write(builder)
    octets = builder.end()
    chunk = Chunk(
        compression="zstd",
        data=zstandard.ZstdCompressor(level=COMPRESSION_LEVEL).compress(octets),
        message_start_time=messages[0][0],
        message_end_time=messages[-1][0],
        uncompressed_crc=zlib.crc32(octets),
        uncompressed_size=len(octets),
    )
    block = _octets(chunk)
    index = _octets(MessageIndex(channel, entries))
    return block + index, ChunkIndex(
        message_start_time=chunk.message_start_time,
        message_end_time=chunk.message_end_time,
        chunk_start_offset=at,
        chunk_length=len(block),
        message_index_offsets={channel: at + len(block)},
        message_index_length=len(index),
        compression=chunk.compression,
        compressed_size=len(chunk.data),
        uncompressed_size=chunk.uncompressed_size,
    )


def _octets(record: McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return builder.end()
