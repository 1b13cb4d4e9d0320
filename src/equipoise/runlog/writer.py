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
from equipoise.runlog.layout import MESSAGE, PACKAGE, make_layout
from equipoise.runlog.mcapfile import McapFile
from equipoise.runlog.packing import TickPacker

LOG_NAME = "run.mcap"
SCENARIO_NAME = "scenario.yaml"
FORMAT = "1"
FLUSH_PERIOD = 0.03  # [s] of simulated or wall time, whichever ends first; 0.1 s stalls a 1 ms loop
CHUNK_BYTES = 1 << 20
LATEST_TIME = 1e9  # [s], far below where nanoseconds leave 64 bits


class RunWriter:
    """Write one run into a new log, tick by tick.

    Use it as a context manager: leaving it, also by Ctrl-C, completes the file. What is on the
    disk can be read at any moment. The folder is created when missing.

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
        self._packer = TickPacker(layout)
        self._capacity = max(1, CHUNK_BYTES // layout.record.itemsize)
        self._ticks: list[tuple[float, bytes]] = []  # those not on the disk yet
        self._first = 0  # number of the first of them
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
        if not self._last_time < t < LATEST_TIME:  # also once closed or failed
            self._refuse_time(t)
        ticks = self._ticks
        ticks.append((t, self._packer.pack(self._first + len(ticks), t, values)))
        self._last_time = t
        if (
            len(ticks) >= self._capacity
            or t - self._flush_time >= FLUSH_PERIOD
            or time.perf_counter() - self._flush_wall >= FLUSH_PERIOD
        ):
            self.flush()

    def flush(self) -> None:
        """Hand all ticks so far to the operating system.

        Raises: RunLogError if the disk refuses.
        """
        self._check_open()
        # A chunk that was written just before an interrupt (Ctrl-C) is not written again.
        fresh = self._ticks[self._file.ticks - self._first :]
        if fresh:
            try:
                self._file.append(fresh)
            except OSError as error:
                raise self._fail(error) from error
            self._safe_time = fresh[-1][0]
        self._first, self._ticks = self._file.ticks, []
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
