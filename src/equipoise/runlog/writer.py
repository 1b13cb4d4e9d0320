"""Writing a run while it runs: a killed run keeps all but its last few hundredths of a second."""

from __future__ import annotations

import platform
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np

from equipoise.errors import InputError, RunLogError
from equipoise.runlog.channels import Channel, channels_to_json, check_channels
from equipoise.runlog.checksums import SUMS, checksums
from equipoise.runlog.folders import LOG_NAME
from equipoise.runlog.layout import MESSAGE, PACKAGE, make_layout
from equipoise.runlog.mcapfile import McapFile
from equipoise.runlog.packing import TickBuffer, nanoseconds
from equipoise.runlog.record import TickRecord

SCENARIO_NAME = "scenario.yaml"
FORMAT = "3"  # 2: with checksums of its texts; 3: each number has a name
FLUSH_PERIOD = 0.03  # [s] of simulated or wall time, whichever ends first; 0.1 s stalls a 1 ms loop
CHUNK_BYTES = 1 << 20
LATEST_TIME = 1e9  # [s], far below where nanoseconds leave 64 bits


class RunWriter:
    """Write one run into a new log, tick by tick.

    Use it as a context manager: leaving it, also by Ctrl-C, completes the file. What is on the
    disk can be read at any moment. The folder is created when missing.

    A tick is written from a mapping (`write`), or, faster, from `record`, whose views are filled
    in place before each `write_record`.

    Raises: RunLogError if the folder cannot be written or holds a log already; InputError for
    channels that clash.
    """

    def __init__(
        self,
        folder: Path,
        channels: Sequence[Channel],
        *,
        scenario_text: str,
        seed: int,
        info: Mapping[str, str] | None = None,
    ) -> None:
        self.folder = Path(folder)
        self.channels = check_channels(channels)
        layout = make_layout(self.channels)
        self._buffer = TickBuffer(layout, max(1, CHUNK_BYTES // layout.record.itemsize))
        self._first = 0  # number of the tick in the buffer's first row
        self._taken = 0  # number of ticks written so far, on the disk or in the buffer
        self._safe_time: float | None = None
        self._last_time = float(np.nextafter(0.0, -1.0))
        self._flush_time = -np.inf
        self._flush_wall = time.perf_counter()
        self._failure: str | None = None
        self._closed = False
        self._file = self._open(layout.schema(), scenario_text, seed, info or {})

    def write(self, t: float, values: Mapping[str, np.ndarray]) -> None:
        """Append one tick at time `t` [s]: one (k,) vector for each channel, by its name.

        Raises: NameNotFoundError, InputError or ShapeError if the values do not fit the channels;
        InputError if time does not increase; RunLogError if the disk refuses.
        """
        t = float(t)
        self._buffer.put_values(self._next_row(t), t, values)
        self._note(t)

    @property
    def record(self) -> TickRecord:
        """The numbers of the next tick, to be filled in place; its memory stays the same."""
        return self._buffer.record

    def write_record(self, t: float) -> None:
        """Append the tick that `record` holds, at time `t` [s].

        Raises: InputError if time does not increase; RunLogError if the disk refuses.
        """
        t = float(t)
        self._buffer.put_record(self._next_row(t), t)
        self._note(t)

    def _next_row(self, t: float) -> int:
        if not self._last_time < t < LATEST_TIME:  # also once closed or failed
            self._refuse_time(t)
        row = self._taken - self._first
        if row < self._buffer.capacity:
            return row
        self.flush()  # the last one was interrupted
        return 0

    def _note(self, t: float) -> None:
        """Count the tick that was put into the buffer, and write a chunk if it is time."""
        self._taken += 1
        self._last_time = t
        if (
            t - self._flush_time >= FLUSH_PERIOD
            or self._taken - self._first >= self._buffer.capacity
            or time.perf_counter() - self._flush_wall >= FLUSH_PERIOD
        ):
            self.flush()

    def flush(self) -> None:
        """Hand all ticks so far to the operating system.

        Raises: RunLogError if the disk refuses.
        """
        self._check_open()
        # A chunk that was written just before an interrupt (Ctrl-C) is not written again.
        buffer, done = self._buffer, self._file.ticks
        start, stop = done - self._first, self._taken - self._first
        if start < stop:
            times = buffer.times[start:stop]
            try:
                self._file.append(nanoseconds(times), buffer.content(start, stop, done))
            except OSError as error:
                raise self._fail(error) from error
            self._safe_time = float(times[-1])
        self._first = self._taken
        self._flush_time = self._last_time
        self._flush_wall = time.perf_counter()

    def close(self) -> None:
        """Complete the file; a second call does nothing.

        Raises: RunLogError if the disk refuses.
        """
        if self._closed:
            return
        try:
            if self._failure is None:
                self.flush()
                self._file.finish()
        except OSError as error:
            raise self._fail(error) from error
        finally:
            self._closed = True
            self._last_time = np.inf
            self._file.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        try:
            self.close()
        except RunLogError as failure:
            if error is None:
                raise
            error.add_note(str(failure))

    def _open(
        self, schema: bytes, scenario_text: str, seed: int, info: Mapping[str, str]
    ) -> McapFile:
        path, scenario = self.folder / LOG_NAME, self.folder / SCENARIO_NAME
        run = {
            "format": FORMAT,
            "seed": str(int(seed)),
            "channels": channels_to_json(self.channels),
            "scenario": scenario_text,
        }
        about = {**_versions(), **{str(key): str(text) for key, text in info.items()}}
        metadata = {"equipoise.run": run, "equipoise.info": about}
        metadata[SUMS] = checksums(metadata)
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            if path.exists():
                raise RunLogError(
                    f"{self.folder} already holds a log ({LOG_NAME}). Nothing was overwritten; "
                    "choose a new folder, for example with new_run_folder."
                )
            scenario.write_text(scenario_text, encoding="utf-8")
            return McapFile(
                path, schema_name=f"{PACKAGE}.{MESSAGE}", schema=schema, metadata=metadata
            )
        except OSError as error:
            raise RunLogError(f"Cannot write a log in {self.folder}: {error.strerror}.") from error

    def _refuse_time(self, t: float) -> None:
        self._check_open()
        if self._closed:
            raise RunLogError(f"The log in {self.folder} is closed; this tick was not written.")
        if self._last_time >= 0.0:
            raise InputError(
                f"Time must increase from tick to tick; the last was at {self._last_time!r} s",
                given=t,
            )
        raise InputError(f"Time must be between 0 and {LATEST_TIME:g} s", given=t)

    def _check_open(self) -> None:
        if self._failure is not None:
            raise RunLogError(self._failure)

    def _fail(self, error: OSError) -> RunLogError:
        """Note the failure, leave whole chunks on the disk, and put it in words."""
        self._last_time = np.inf
        with suppress(OSError):
            self._file.cut()
        safe = (
            f"The run is safe up to t = {self._safe_time:.6g} s ({self._file.ticks} ticks)"
            if self._safe_time is not None
            else "No tick of it is on the disk"
        )
        self._failure = (
            f"Cannot go on writing {self.folder / LOG_NAME}: {error.strerror}. {safe}; "
            "free some space or choose another folder, and run again."
        )
        return RunLogError(self._failure)


def _versions() -> dict[str, str]:
    """Say with what, on what and when the run was made."""
    about = {"created": datetime.now(UTC).isoformat(timespec="seconds")}
    for name, package in (("equipoise", "equipoise"), ("numpy", "numpy"), ("pinocchio", "pin")):
        try:
            about[name] = version(package)
        except PackageNotFoundError:
            about[name] = "not installed"
    about["python"] = platform.python_version()
    about["platform"] = platform.platform()
    return about
