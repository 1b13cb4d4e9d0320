"""The numbers of one tick in memory that is made once and filled in place."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from equipoise.errors import NameNotFoundError
from equipoise.runlog.channels import Channel


class TickRecord:
    """One array of doubles for all channels, and a view into it for each.

    `numbers` (n,) holds the channels one after the other, as `places` says by name; `views` maps a
    name to its part (k,). All are NaN at first; what a tick does not fill stays as it was.
    """

    def __init__(self, channels: Sequence[Channel]) -> None:
        ends = np.cumsum([0, *(channel.size for channel in channels)]).tolist()
        self.numbers = np.full(ends[-1], np.nan)
        places = {
            channel.name: slice(start, stop)
            for channel, start, stop in zip(channels, ends[:-1], ends[1:], strict=True)
        }
        self.places: Mapping[str, slice] = MappingProxyType(places)
        self.views: Mapping[str, np.ndarray] = MappingProxyType(
            {name: self.numbers[place] for name, place in places.items()}
        )

    def __getitem__(self, name: str) -> np.ndarray:
        """Return the view (k,) of a channel. Raises: NameNotFoundError."""
        try:
            return self.views[name]
        except KeyError:
            raise NameNotFoundError("channel", str(name), tuple(self.views)) from None
