"""Turning the vectors of one tick into its bytes, with every doubt about them raised here."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from equipoise.errors import InputError, NameNotFoundError, ShapeError
from equipoise.runlog.channels import Channel
from equipoise.runlog.layout import TickLayout

_DOUBLE = np.dtype("<f8")


class TickPacker:
    """Pack ticks of one layout."""

    def __init__(self, layout: TickLayout) -> None:
        self._layout = layout
        self._names = tuple(channel.name for channel in layout.channels)
        self._sizes = [channel.size for channel in layout.channels]
        self._types = [_DOUBLE] * len(layout.channels)
        self._length = layout.record.itemsize
        self._parts: list[bytes | np.ndarray] = [b""] * (1 + 2 * len(layout.channels))
        self._parts[1::2] = layout.heads

    def pack(self, sequence: int, t: float, values: Mapping[str, np.ndarray]) -> bytes:
        """Return the record of tick number `sequence` at time `t` [s].

        Raises: NameNotFoundError, InputError or ShapeError if the values do not fit the channels.
        """
        opening = self._layout.opening(sequence, round(t * 1e9), t)
        try:
            vectors = [values[name] for name in self._names]
            plain = (
                len(values) == len(vectors)
                and [vector.dtype for vector in vectors] == self._types
                and [*map(len, vectors)] == self._sizes
            )
            if plain:
                record = self._join(opening, vectors)
                if len(record) == self._length:  # not so if a vector has a second axis
                    return record
        except (KeyError, TypeError, AttributeError, ValueError, BufferError):
            pass  # the slow path converts what it can and says what it cannot
        return self._join(opening, self._converted(values))

    def _join(self, opening: bytes, vectors: list[np.ndarray]) -> bytes:
        self._parts[0] = opening
        self._parts[2::2] = vectors
        return b"".join(self._parts)

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
        return [_vector(channel, values[channel.name]) for channel in self._layout.channels]


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
