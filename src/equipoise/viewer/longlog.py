"""A log of any length: where its pieces are, one tick of it, and the envelope of its curves.

Only the places of the chunks are read at once; a tick costs one chunk, an envelope grows piece by
piece and says after each pass what it has seen.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from equipoise.errors import RunLogError
from equipoise.runlog import CHECKED_WHOLE, Run, check_log, load_run
from equipoise.runlog.folders import LOG_NAME
from equipoise.runlog.reader import layout_of
from equipoise.runlog.scan import read_chunk, scan_log
from equipoise.spatial import Array

CACHED_CHUNKS = 64


@dataclass(frozen=True)
class Tick:
    """What was logged at time `t` [s], by channel."""

    t: float
    values: Mapping[str, Array]


class LongLog:
    """Answer for single ticks and for pieces of a log, without loading it whole.

    `run` is the run without its ticks; `note` says what is damaged, of a very long log only what
    can be told without reading it. Raises: `RunLogError` if there is nothing to show.
    """

    def __init__(self, folder_or_mcap: Path | str) -> None:
        given = Path(folder_or_mcap)
        self.run: Run = load_run(given, start=-1.0, stop=-1.0)
        self.path = given / LOG_NAME if given.is_dir() else given
        self.note = check_log(self.path, at_most=CHECKED_WHOLE)
        with open(self.path, "rb") as stream:
            scan = scan_log(stream, self.path)
        self._chunks = scan.chunks
        self._layout = layout_of(scan, tuple(self.run.channels.values()))
        self._starts = np.array([chunk.first for chunk in self._chunks])
        self._cache: OrderedDict[int, np.ndarray | None] = OrderedDict()
        self._lock = threading.Lock()
        self.chunks_read = 0
        first, last = self._first_intact(1), self._first_intact(-1)
        self.t_first, self.t_last = float(first["t"][0]), float(last["t"][-1])

    @property
    def chunk_count(self) -> int:
        """Number of pieces on the disk."""
        return len(self._chunks)

    def at(self, t: float) -> Tick:
        """Return the last tick at or before `t` [s] (the first one if `t` is before it)."""
        chunk = max(int(np.searchsorted(self._starts, t + 1e-9, side="right")) - 1, 0)
        records = self._intact(chunk, -1) if t > self.t_first else self._first_intact(1)
        index = int(np.searchsorted(records["t"], t + 1e-9, side="right")) - 1
        return self._tick(records, max(index, 0))

    def after(self, t: float) -> Tick:
        """Return the first tick after `t` [s], the last one if there is none."""
        tick = self.at(t)
        chunk = max(int(np.searchsorted(self._starts, tick.t + 1e-9, side="right")) - 1, 0)
        for candidate in range(chunk, len(self._chunks)):
            records = self._records(candidate)
            if records is not None and records["t"][-1] > t + 1e-9:
                index = int(np.searchsorted(records["t"], t + 1e-9, side="right"))
                return self._tick(records, index)
        return self.at(self.t_last)

    def before(self, t: float) -> Tick:
        """Return the last tick before `t` [s], the first one if there is none."""
        return self.at(t - 2e-9)

    def pieces(self, passes: tuple[int, ...]) -> Iterator[tuple[int, Mapping[str, Array]]]:
        """Yield (pass number, arrays by channel and "t") of chunk after chunk, coarse passes first.

        Pass k reads every `passes[k]`-th chunk that no earlier pass has read; end with 1 for all.
        """
        seen = np.zeros(len(self._chunks), dtype=bool)
        for number, stride in enumerate(passes):
            wanted = set(range(0, len(self._chunks), stride))
            if number == 0:
                wanted.add(len(self._chunks) - 1)
            for chunk in sorted(k for k in wanted if not seen[k]):
                seen[chunk] = True
                records = self._read(chunk)
                if records is not None:
                    yield number, {"t": records["t"], **self._arrays(records)}

    def _tick(self, records: np.ndarray, index: int) -> Tick:
        tick = records[index : index + 1]
        values = {name: rows[0] for name, rows in self._arrays(tick).items()}
        return Tick(float(tick["t"][0]), values)

    def _arrays(self, records: np.ndarray) -> dict[str, np.ndarray]:
        return {
            name: self._layout.values(records, i).copy() for i, name in enumerate(self.run.channels)
        }

    def _first_intact(self, direction: int) -> np.ndarray:
        if not self._chunks:
            raise RunLogError(f"{self.path} holds no tick: there is nothing to show.")
        return self._intact(0 if direction > 0 else len(self._chunks) - 1, direction)

    def _intact(self, chunk: int, direction: int) -> np.ndarray:
        """Return the nearest readable chunk in that direction, else in the other one."""
        ahead = range(chunk, len(self._chunks) if direction > 0 else -1, direction)
        behind = range(chunk, -1 if direction > 0 else len(self._chunks), -direction)
        for candidate in (*ahead, *behind):
            records = self._records(candidate)
            if records is not None:
                return records
        raise RunLogError(f"{self.path} is damaged: none of its ticks can be read.")

    def _records(self, chunk: int) -> np.ndarray | None:
        with self._lock:
            if chunk in self._cache:
                self._cache.move_to_end(chunk)
                return self._cache[chunk]
        records = self._read(chunk)
        with self._lock:
            self._cache[chunk] = records
            while len(self._cache) > CACHED_CHUNKS:
                self._cache.popitem(last=False)
        return records

    def _read(self, chunk: int) -> np.ndarray | None:
        self.chunks_read += 1
        try:
            with open(self.path, "rb") as stream:
                content = read_chunk(stream, self._chunks[chunk])
        except OSError:
            return None
        records = None if content is None else self._layout.view(content)
        return records if records is not None and records.size else None
