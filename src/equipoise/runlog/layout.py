"""The fixed layout of one tick as a protobuf message, so that ticks are copied, never encoded.

All channels have a fixed size, hence every encoded message has the same bytes except for its
numbers: writing ticks copies numbers between constant bytes, and a numpy record type describes the
result, so that reading a million ticks is one look at a buffer. Any protobuf decoder reads the same
bytes with the schema from `schema`.

A channel is a message of its own with one double for each label, so that other tools show each
number by its name: `q.left_knee`. Before format 3 it was a list of doubles; of a channel with more
than `MOST_NAMED` labels it still is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from google.protobuf import descriptor_pb2

from equipoise.errors import InputError
from equipoise.runlog.channels import Channel
from equipoise.runlog.field_names import field_names

PACKAGE = "equipoise"
MESSAGE = "Tick"
MAGIC = b"\x89MCAP0\r\n"  # with which an MCAP file begins and ends
TOPIC = "/tick"
CHANNEL_ID = 1
OPCODE_MESSAGE = 0x05
FIRST_FIELD = 2
MOST_CHANNELS = 10_000  # protobuf keeps field numbers from 19000 on for itself
SHORT_TAGS = 15  # fields whose tags are one byte
MOST_NAMED = 2047 - SHORT_TAGS  # fields whose tags are two bytes: all of a channel are as long

TIME_TAG = 1 << 3 | 1  # field 1, eight bytes

_RECORD_HEAD = 9  # opcode and length, which the length itself does not count


@dataclass(frozen=True)
class TickLayout:
    """Hold the record type of one tick and the bytes that never change.

    `record` is the numpy record type of a whole MCAP message record; `values` gives the numbers of
    a channel in such records. `fields` are the protobuf field names; at the byte `places` a record
    always holds `pattern`. `named` says for each channel whether its numbers have names.
    """

    channels: tuple[Channel, ...]
    fields: tuple[str, ...]
    named: tuple[bool, ...]
    record: np.dtype
    places: np.ndarray
    pattern: np.ndarray

    def values(self, records: np.ndarray, channel: int) -> np.ndarray:
        """Return the numbers (n, k) of a channel, by its place, as a view into records (n,)."""
        part = records[f"values{channel}"]
        return part["number"] if self.named[channel] else part

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
        one, double = kinds.LABEL_OPTIONAL, kinds.TYPE_DOUBLE
        message.field.add(name="t", number=1, type=double, label=one)
        for i, (name, channel) in enumerate(zip(self.fields, self.channels, strict=True)):
            number = FIRST_FIELD + i
            if not self.named[i]:
                message.field.add(name=name, number=number, type=double, label=kinds.LABEL_REPEATED)
                continue
            kind = f"Channel{number}"
            message.field.add(
                name=name,
                number=number,
                type=kinds.TYPE_MESSAGE,
                label=one,
                type_name=f".{PACKAGE}.{MESSAGE}.{kind}",
            )
            nested = message.nested_type.add(name=kind)
            first = _first_number(channel.size)
            for k, label in enumerate(field_names(channel.labels)):
                nested.field.add(name=label, number=first + k, type=double, label=one)
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


def make_layout(channels: Sequence[Channel], *, named: bool = True) -> TickLayout:
    """Lay out the message for these channels; before format 3 no number was `named`.

    Raises: InputError if there are more channels than protobuf has field numbers for.
    """
    if len(channels) > MOST_CHANNELS:
        raise InputError(f"A log holds at most {MOST_CHANNELS} channels", given=len(channels))
    with_names = tuple(named and channel.size <= MOST_NAMED for channel in channels)
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
    heads, tags = [], []
    for i, (channel, by_name) in enumerate(zip(channels, with_names, strict=True)):
        tags.append(_tags(channel.size) if by_name else np.empty((channel.size, 0), "u1"))
        width = tags[-1].shape[1]
        heads.append(_head(FIRST_FIELD + i, (width + 8) * channel.size))
        kind = [("tag", "u1", (width,)), ("number", "<f8")] if by_name else "<f8"
        parts.append((f"head{i}", "u1", (len(heads[-1]),)))
        parts.append((f"values{i}", kind, (channel.size,)))
    record = np.dtype(parts)
    places, pattern = _constants(record, heads, tags)
    names = field_names((channel.name for channel in channels), taken=("t",), stem="channel")
    return TickLayout(tuple(channels), tuple(names), with_names, record, places, pattern)


def _constants(
    record: np.dtype, heads: Sequence[bytes], tags: Sequence[np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the byte offsets in a record where every tick holds the same, and what it holds."""
    blank, mask = np.zeros((2, 1), dtype=record)
    blank["opcode"], blank["length"] = OPCODE_MESSAGE, record.itemsize - _RECORD_HEAD
    blank["time_tag"] = TIME_TAG
    mask["opcode"] = mask["time_tag"] = 0xFF
    mask["length"] = 0xFFFFFFFFFFFFFFFF
    for i, (head, tag) in enumerate(zip(heads, tags, strict=True)):
        blank[f"head{i}"], mask[f"head{i}"] = np.frombuffer(head, "u1"), 0xFF
        if tag.size:
            blank[f"values{i}"]["tag"], mask[f"values{i}"]["tag"] = tag, 0xFF
    places = np.flatnonzero(mask.view("u1"))
    return places, blank.view("u1")[places]


def _head(number: int, octets: int) -> bytes:
    """Bytes before what a channel holds: tag (wire type 2) and length [bytes]."""
    return _varint(number << 3 | 2) + _varint(octets)


def _first_number(size: int) -> int:
    """Return the number of the first field of `size`, so that the tags of all are as long."""
    return 1 if size <= SHORT_TAGS else SHORT_TAGS + 1


def _tags(size: int) -> np.ndarray:
    """Return the tags (size, 1 or 2) of as many doubles (wire type 1)."""
    first = _first_number(size)
    tags = [np.frombuffer(_varint(first + k << 3 | 1), "u1") for k in range(size)]
    return np.array(tags, dtype="u1").reshape(size, -1 if size else 1)


def _varint(value: int) -> bytes:
    groups = bytearray()
    while value > 0x7F:
        groups.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes((*groups, value))
