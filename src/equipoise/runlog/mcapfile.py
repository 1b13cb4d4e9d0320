"""An MCAP file with one topic, appended so that whatever is on the disk can be read.

Each chunk is put together in memory and written by one call at a known place. A chunk counts only
once it is noted in `_commits`, and its place follows from there: a write that was interrupted
(Ctrl-C) or failed (disk full) is written over or cut off, never left in the middle of the file.
"""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from io import FileIO
from pathlib import Path

import numpy as np
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    Chunk,
    ChunkIndex,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
)

from equipoise.runlog.layout import CHANNEL_ID, MAGIC, TOPIC
from equipoise.runlog.mcap_summary import ending

COMPRESSION_LEVEL = -20  # of zstd; doubles hardly shrink: level -5 saves 4 % more at twice the time

_INDEX_HEAD = struct.Struct("<BQHI")  # opcode, length, channel and size of the entries
_INDEX_FIXED = 6  # bytes of the channel and of that size


@dataclass(frozen=True)
class _Commit:
    """A chunk that is on the disk; `ticks` and `end` [bytes] count from the start of the file."""

    ticks: int
    end: int
    index: ChunkIndex | None


class McapFile:
    """Append chunks of ticks to a new MCAP file.

    Raises: OSError wherever the operating system refuses; FileExistsError if the file exists.
    """

    def __init__(
        self, path: Path, *, schema_name: str, schema: bytes, metadata: Mapping[str, dict[str, str]]
    ) -> None:
        self._schema = Schema(id=1, data=schema, encoding="protobuf", name=schema_name)
        self._channel = Channel(
            id=CHANNEL_ID, topic=TOPIC, message_encoding="protobuf", metadata={}, schema_id=1
        )
        self._metadata_indexes: list[MetadataIndex] = []
        self._compressor = zstandard.ZstdCompressor(level=COMPRESSION_LEVEL)
        self._commits: list[_Commit] = []
        self._stream = _create(path)
        try:
            self._write_opening(metadata)
        except BaseException:
            self._stream.close()
            raise

    @property
    def ticks(self) -> int:
        """Number of ticks on the disk."""
        return self._commits[-1].ticks

    def append(self, times: np.ndarray, content: np.ndarray) -> None:
        """Write one chunk of ticks: their times (n,) [ns] and, as octets, their message records."""
        last, octets = self._commits[-1], content.data
        chunk = Chunk(
            compression="zstd",
            data=self._compressor.compress(octets),
            message_start_time=int(times[0]),
            message_end_time=int(times[-1]),
            uncompressed_crc=zlib.crc32(octets),
            uncompressed_size=len(content),
        )
        builder = RecordBuilder()
        chunk.write(builder)
        length = builder.count
        block = builder.end() + _message_index(times, len(content))
        index = ChunkIndex(
            message_start_time=chunk.message_start_time,
            message_end_time=chunk.message_end_time,
            chunk_start_offset=last.end,
            chunk_length=length,
            message_index_offsets={CHANNEL_ID: last.end + length},
            message_index_length=len(block) - length,
            compression=chunk.compression,
            compressed_size=len(chunk.data),
            uncompressed_size=chunk.uncompressed_size,
        )
        commit = _Commit(last.ticks + len(times), last.end + len(block), index)
        self._write(block, last.end)
        self._commits.append(commit)

    def finish(self) -> None:
        """Write the summary and the footer."""
        end = self._commits[-1].end
        groups: dict[Opcode, list[McapRecord]] = {
            Opcode.SCHEMA: [self._schema],
            Opcode.CHANNEL: [self._channel],
            Opcode.STATISTICS: [self._statistics()],
            Opcode.CHUNK_INDEX: self._chunk_indexes(),
            Opcode.METADATA_INDEX: list(self._metadata_indexes),
        }
        block = ending(groups, end)
        self._write(block, end)
        os.ftruncate(self._stream.fileno(), end + len(block))

    def cut(self) -> None:
        """Cut off what follows the last whole chunk."""
        os.ftruncate(self._stream.fileno(), self._commits[-1].end)

    def close(self) -> None:
        """Close the file as it is."""
        self._stream.close()

    def _write_opening(self, metadata: Mapping[str, dict[str, str]]) -> None:
        builder = RecordBuilder()
        builder.write(MAGIC)
        Header(profile="", library="equipoise").write(builder)
        for name, content in metadata.items():
            offset = builder.count
            Metadata(name=name, metadata=content).write(builder)
            self._metadata_indexes.append(MetadataIndex(offset, builder.count - offset, name))
        self._schema.write(builder)
        self._channel.write(builder)
        block = builder.end()
        self._write(block, 0)
        self._commits.append(_Commit(0, len(block), None))

    def _write(self, block: bytes, offset: int) -> None:
        remaining = memoryview(block)
        while remaining:
            written = os.pwrite(self._stream.fileno(), remaining, offset)
            remaining, offset = remaining[written:], offset + written

    def _chunk_indexes(self) -> list[McapRecord]:
        return [commit.index for commit in self._commits if commit.index is not None]

    def _statistics(self) -> Statistics:
        indexes = [commit.index for commit in self._commits if commit.index is not None]
        return Statistics(
            attachment_count=0,
            channel_count=1,
            channel_message_counts={CHANNEL_ID: self.ticks},
            chunk_count=len(indexes),
            message_count=self.ticks,
            message_start_time=indexes[0].message_start_time if indexes else 0,
            message_end_time=indexes[-1].message_end_time if indexes else 0,
            metadata_count=len(self._metadata_indexes),
            schema_count=1,
        )


def _message_index(times: np.ndarray, size: int) -> bytes:
    """Return the record that says where in `size` bytes the message of each time (n,) [ns] is."""
    entries = np.empty((len(times), 2), dtype="<u8")
    entries[:, 0] = times
    entries[:, 1] = np.arange(0, size, size // len(times))  # all records have the same length
    head = _INDEX_HEAD.pack(
        Opcode.MESSAGE_INDEX, entries.nbytes + _INDEX_FIXED, CHANNEL_ID, entries.nbytes
    )
    return head + entries.tobytes()


def _create(path: Path) -> FileIO:
    """Open a new file for unbuffered writing."""
    return open(path, "xb", buffering=0)
