"""The end of an MCAP file: what it holds, once more, and where."""

from __future__ import annotations

import zlib
from collections.abc import Mapping, Sequence

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import DataEnd, Footer, McapRecord, SummaryOffset

from equipoise.runlog.layout import MAGIC


def ending(groups: Mapping[Opcode, Sequence[McapRecord]], at: int) -> bytes:
    """Return what follows the last chunk: end of data, summary of these records, footer.

    It begins at byte `at` of the file.
    """
    builder = RecordBuilder()
    DataEnd(0).write(builder)
    start = at + builder.count
    return builder.end() + _summary(groups, start) + MAGIC


def _summary(groups: Mapping[Opcode, Sequence[McapRecord]], start: int) -> bytes:
    builder = RecordBuilder()
    offsets = []
    for opcode, records in groups.items():
        group_start = builder.count
        for record in records:
            record.write(builder)
        offsets.append(SummaryOffset(opcode, start + group_start, builder.count - group_start))
    offsets_start = start + builder.count
    for offset in offsets:
        offset.write(builder)
    summary = builder.end()
    Footer(start, offsets_start, 0).write(builder)
    unsigned = builder.end()[:-4]  # the footer's last field is the checksum of all before it
    return summary + unsigned + zlib.crc32(summary + unsigned).to_bytes(4, "little")
