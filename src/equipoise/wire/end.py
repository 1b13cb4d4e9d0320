"""One end of a wire: takes what arrives, believes only what is whole and in order, counts the rest.

This keeps faults out, not an attacker who can read the packets.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator

from equipoise.wire.datagrams import Address, Datagrams
from equipoise.wire.model import WireModel
from equipoise.wire.packets import Codec, Fault, Header

AT_ONCE = 256  # packets looked at in one go: a flood does not hold up a loop
FARTHEST = 1 << 16  # messages that may be lost in a row: a minute at a kilohertz


class End:
    """What both ends share: session number, sequence, counts."""

    def __init__(self, model: WireModel, datagrams: Datagrams) -> None:
        self.codec, self.datagrams = Codec(model), datagrams
        self.session = int.from_bytes(os.urandom(8), "little") or 1
        self.dropped: Counter[Fault] = Counter()
        self._sequence = 0

    def next_sequence(self) -> int:
        """Return the number of the next packet."""
        self._sequence += 1
        return self._sequence

    def packets(self) -> Iterator[tuple[bytes, Header | Fault, Address]]:
        """Yield what has arrived with its header, or what is wrong with it."""
        for _ in range(AT_ONCE):
            taken = self.datagrams.take()
            if taken is None:
                return
            packet, sender = taken
            yield packet, self.codec.header(packet), sender

    def drop(self, fault: Fault) -> None:
        """Count a packet that is not believed."""
        self.dropped[fault] += 1


def out_of_order(sequence: int, last: int) -> Fault | None:
    """Return what is wrong with a sequence number after the last one that was believed."""
    if sequence <= last:
        return Fault.OLD
    return Fault.JUMP if sequence > last + FARTHEST else None
