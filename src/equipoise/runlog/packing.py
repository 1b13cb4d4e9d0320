"""From the numbers of ticks to the bytes of a chunk; what does not fit the channels is refused.

Ticks are gathered as rows of doubles. Only when a chunk is written do they become records, channel
by channel for all of its ticks at once, between bytes that never change and were written before.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from equipoise.errors import InputError, NameNotFoundError, ShapeError
from equipoise.runlog.channels import Channel
from equipoise.runlog.layout import TickLayout
from equipoise.runlog.record import TickRecord

_DOUBLE = np.dtype("<f8")


class TickBuffer:
    """Room for `capacity` ticks of one layout: `times` [s] and `rows` (capacity, n) of numbers."""

    def __init__(self, layout: TickLayout, capacity: int) -> None:
        self.capacity = capacity
        self.record = TickRecord(layout.channels)
        self._numbers = self.record.numbers
        self.times = np.zeros(capacity)
        self.rows = np.zeros((capacity, self.record.numbers.size))
        self._channels = layout.channels
        self._names = tuple(channel.name for channel in layout.channels)
        self._sizes = [channel.size for channel in layout.channels]
        self._records = layout.blank(capacity)
        self._octets = self._records.view("u1")
        self._copies = [
            (layout.values(self._records, i), self.rows[:, place])
            for i, place in enumerate(self.record.places.values())
        ]

    def put_record(self, row: int, t: float) -> None:
        """Copy the numbers of `record` to a row, for the tick at time `t` [s]."""
        self.rows[row] = self._numbers
        self.times[row] = t

    def put_values(self, row: int, t: float, values: Mapping[str, np.ndarray]) -> None:
        """Copy one vector a channel to a row, for the tick at time `t` [s].

        Raises: NameNotFoundError, InputError or ShapeError if the values do not fit the channels.
        """
        self.times[row] = t
        try:
            vectors = [values[name] for name in self._names]
            if len(values) == len(vectors) and [*map(len, vectors)] == self._sizes:
                np.concatenate(vectors, out=self.rows[row], casting="no")
                return
        except (KeyError, TypeError, ValueError):
            pass  # the slow path converts what it can and says what it cannot
        np.concatenate(self._converted(values), out=self.rows[row])

    def content(self, start: int, stop: int, first: int) -> np.ndarray:
        """Return the message records of rows start..stop as octets, valid until the next call.

        The tick of row `start` has the number `first`.
        """
        count = stop - start
        records = self._records[:count]
        records["sequence"] = np.arange(first, first + count)
        records["t"] = self.times[start:stop]
        records["log_time"] = records["publish_time"] = nanoseconds(self.times[start:stop])
        for target, source in self._copies:
            target[:count] = source[start:stop]
        return self._octets[: count * self._records.itemsize]

    def _converted(self, values: Mapping[str, np.ndarray]) -> list[np.ndarray]:
        for name in values:
            if name not in self._names:
                raise NameNotFoundError("channel", str(name), self._names)
        missing = [name for name in self._names if name not in values]
        if missing:
            raise InputError(
                "A tick lacks channels",
                given=list(values),
                known=self._names,
                remedy=f"Give {', '.join(missing)} too; NaN stands for what is not known",
            )
        return [_vector(channel, values[channel.name]) for channel in self._channels]


def nanoseconds(times: np.ndarray) -> np.ndarray:
    """Return times [s] in whole nanoseconds."""
    return np.rint(times * 1e9).astype(np.uint64)


def _vector(channel: Channel, values: object) -> np.ndarray:
    """Convert lists, numbers and arrays of other real types to doubles in one piece."""
    try:
        vector = np.atleast_1d(np.asarray(values))
    except ValueError as error:  # a ragged list
        raise InputError(f"Channel {channel.name!r} wants one vector", given=values) from error
    if vector.dtype.kind not in "biuf":
        raise InputError(f"Channel {channel.name!r} wants real numbers", given=values)
    if vector.shape != (channel.size,):
        raise ShapeError(f"channel {channel.name!r}", vector.shape, (channel.size,))
    return np.ascontiguousarray(vector, dtype=_DOUBLE)
