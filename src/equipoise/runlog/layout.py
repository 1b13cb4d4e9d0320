"""The fixed layout of one tick as a protobuf message, so that ticks are copied, never encoded.

All channels have a fixed size, hence every encoded message has the same bytes except for its
numbers: writing ticks copies numbers between constant bytes, and a numpy record type describes the
result, so that reading a million ticks is one look at a buffer. Any protobuf decoder reads the same
bytes with the schema from `schema`.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from google.protobuf import descriptor_pb2

from equipoise.errors import InputError
from equipoise.runlog.channels import Channel

PACKAGE = "equipoise"
MESSAGE = "Tick"
CHANNEL_ID = 1
OPCODE_MESSAGE = 0x05
FIRST_FIELD = 2
MOST_CHANNELS = 10_000  # protobuf keeps field numbers from 19000 on for itself

TIME_TAG = 1 << 3 | 1  # field 1, eight bytes

_RECORD_HEAD = 9  # opcode and length, which the length itself does not count


@dataclass(frozen=True)
class TickLayout:
    """Hold the record type of one tick and the bytes that never change.

    `record` is the numpy record type of a whole MCAP message record, in which "values0" holds the
    numbers of the first channel and so on; `fields` are the protobuf field names and `heads` the
    bytes before the numbers of each channel; at the byte `places` a record always holds `pattern`.
    """

    channels: tuple[Channel, ...]
    fields: tuple[str, ...]
    heads: tuple[bytes, ...]
    record: np.dtype
    places: np.ndarray
    pattern: np.ndarray

    def blank(self, count: int) -> np.ndarray:
        """Return (count,) records with the bytes that never change, and zeros."""
        records = np.zeros(count, dtype=self.record)
        records.view("u1").reshape(count, -1)[:, self.places] = self.pattern
        records["channel_id"] = CHANNEL_ID
        return records

    def schema(self) -> bytes:
        """Serialised FileDescriptorSet with the message type `equipoise.Tick`."""
        files = descriptor_pb2.FileDescriptorSet()
        file = files.file.add(name="equipoise/tick.proto", package=PACKAGE, syntax="proto3")
        message = file.message_type.add(name=MESSAGE)
        kinds = descriptor_pb2.FieldDescriptorProto
        message.field.add(name="t", number=1, type=kinds.TYPE_DOUBLE, label=kinds.LABEL_OPTIONAL)
        for number, name in enumerate(self.fields, start=FIRST_FIELD):
            message.field.add(
                name=name, number=number, type=kinds.TYPE_DOUBLE, label=kinds.LABEL_REPEATED
            )
        return files.SerializeToString(deterministic=True)

    def view(self, content: bytes) -> np.ndarray | None:
        """Return the (n,) records in `content`, or None if it holds anything else."""
        size = self.record.itemsize
        if len(content) % size:
            return None
        octets = np.frombuffer(content, dtype="u1").reshape(-1, size)
        if np.any(octets[:, self.places] != self.pattern):
            return None
        return np.frombuffer(content, dtype=self.record)


def make_layout(channels: Sequence[Channel]) -> TickLayout:
    """Lay out the message for these channels.

    Raises: InputError if there are more channels than protobuf has field numbers for.
    """
    if len(channels) > MOST_CHANNELS:
        raise InputError(f"A log holds at most {MOST_CHANNELS} channels", given=len(channels))
    parts: list[tuple[Any, ...]] = [
        ("opcode", "u1"),
        ("length", "<u8"),
        ("channel_id", "<u2"),
        ("sequence", "<u4"),
        ("log_time", "<u8"),
        ("publish_time", "<u8"),
        ("time_tag", "u1"),
        ("t", "<f8"),
    ]
    heads = [_head(FIRST_FIELD + i, channel.size) for i, channel in enumerate(channels)]
    for i, (head, channel) in enumerate(zip(heads, channels, strict=True)):
        parts.append((f"head{i}", "u1", (len(head),)))
        parts.append((f"values{i}", "<f8", (channel.size,)))
    record = np.dtype(parts)
    places, pattern = _constants(record, heads)
    return TickLayout(
        tuple(channels), _field_names(channels), tuple(heads), record, places, pattern
    )


def _constants(record: np.dtype, heads: Sequence[bytes]) -> tuple[np.ndarray, np.ndarray]:
    """Return the byte offsets in a record where every tick holds the same, and what it holds."""
    blank, mask = np.zeros((2, 1), dtype=record)
    blank["opcode"], blank["length"] = OPCODE_MESSAGE, record.itemsize - _RECORD_HEAD
    blank["time_tag"] = TIME_TAG
    mask["opcode"] = mask["time_tag"] = 0xFF
    mask["length"] = 0xFFFFFFFFFFFFFFFF
    for i, head in enumerate(heads):
        blank[f"head{i}"], mask[f"head{i}"] = np.frombuffer(head, "u1"), 0xFF
    places = np.flatnonzero(mask.view("u1"))
    return places, blank.view("u1")[places]


def _head(number: int, size: int) -> bytes:
    """Bytes before a packed list of `size` doubles: tag (wire type 2) and length [bytes]."""
    return _varint(number << 3 | 2) + _varint(8 * size)


def _varint(value: int) -> bytes:
    groups = bytearray()
    while value > 0x7F:
        groups.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes((*groups, value))


def _field_names(channels: Sequence[Channel]) -> tuple[str, ...]:
    """Legal and distinct identifiers, also where JSON drops underscores and case."""
    taken = {"t"}
    names = []
    for channel in channels:
        stem = re.sub(r"\W+", "_", channel.name, flags=re.ASCII).strip("_")
        stem = stem if re.match(r"[A-Za-z]", stem) else f"channel_{stem}".rstrip("_")
        name, count = stem, 1
        while _folded(name) in taken:
            count += 1
            name = f"{stem}_n{count}"
        taken.add(_folded(name))
        names.append(name)
    return tuple(names)


def _folded(name: str) -> str:
    return name.replace("_", "").lower()
