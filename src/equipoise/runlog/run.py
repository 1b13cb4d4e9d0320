"""A run that was read back: read-only arrays by name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from equipoise.errors import InputError, NameNotFoundError, NonFiniteError
from equipoise.runlog.channels import Channel


@dataclass(frozen=True, eq=False)
class Run:
    """Hold what a log says about one run.

    `t` (N,) [s] are the times of the ticks; `arrays` maps each channel's name to its (N, k)
    values; all arrays are read-only. `info` holds versions, platform and creation time. `summary`
    is the content of summary.json, None without one. `complete` is False when the end of the log
    is missing or a part of it is damaged; `note` then says so in words.
    """

    folder: Path
    t: np.ndarray
    arrays: Mapping[str, np.ndarray]
    channels: Mapping[str, Channel]
    scenario_text: str
    seed: int
    info: Mapping[str, str]
    summary: dict[str, Any] | None
    complete: bool
    note: str = ""

    @property
    def metrics(self) -> Mapping[str, Any]:
        """Value, unit and meaning of each metric by name, from the summary; empty without one."""
        return (self.summary or {}).get("metrics", {})

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the channels, in the order they were logged."""
        return tuple(self.channels)

    def __getitem__(self, name: str) -> np.ndarray:
        """Return the (N, k) values of one channel.

        Raises: NameNotFoundError if there is no such channel.
        """
        try:
            return self.arrays[name]
        except KeyError:
            raise NameNotFoundError("channel", str(name), self.names) from None

    def __contains__(self, name: object) -> bool:
        return name in self.arrays

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __repr__(self) -> str:
        span = f"{self.t[0]:g} to {self.t[-1]:g} s" if self.t.size else "no time"
        state = "" if self.complete else ", incomplete"
        return f"Run({self.folder.name}: {self.t.size} ticks, {span}{state})"

    def at(self, t: float) -> int:
        """Return the index of the tick nearest to time `t` [s], the first or last outside.

        Raises: NonFiniteError if `t` is NaN; InputError if the run has no ticks.
        """
        if np.isnan(t):
            raise NonFiniteError("A time is needed to find a tick", given=t)
        if not self.t.size:
            raise InputError(f"The run in {self.folder} has no ticks", given=t)
        after = int(np.searchsorted(self.t, t))
        if after == 0 or after == self.t.size:
            return min(after, self.t.size - 1)
        return after - 1 if t - self.t[after - 1] <= self.t[after] - t else after
