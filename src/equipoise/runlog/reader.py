"""Reading a run back, whole or in pieces, finished or cut off."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, BinaryIO

import numpy as np

from equipoise.errors import EquipoiseError, InputError, RunLogError
from equipoise.runlog.channels import channels_from_json
from equipoise.runlog.folders import SUMMARY_NAME, read_summary
from equipoise.runlog.layout import TickLayout, make_layout
from equipoise.runlog.run import Run
from equipoise.runlog.scan import Scan, cut_off_early, read_chunk, scan_log
from equipoise.runlog.writer import FORMAT, LOG_NAME

_MARGIN = 1e-6  # [s], as a chunk's times are rounded to nanoseconds


@dataclass(frozen=True)
class _Window:
    """Which ticks are wanted: start <= t < stop [s], and of these every `stride`-th."""

    start: float
    stop: float
    stride: int


def load_run(
    folder_or_mcap: Path | str,
    *,
    start: float | None = None,
    stop: float | None = None,
    stride: int = 1,
) -> Run:
    """Load a run from its folder or its run.mcap, also while it is still being written.

    Only ticks with start <= t < stop [s] are loaded, and of these every `stride`-th, so that a
    long log can be read in pieces. A log that was cut off or damaged gives what is left of it.

    Raises: RunLogError if there is no log or nothing of it can be read; InputError for a window
    that makes no sense.
    """
    window = _make_window(start, stop, stride)
    path = Path(folder_or_mcap)
    try:
        path = _find_log(path)
        with open(path, "rb") as stream:
            scan = scan_log(stream, path)
            run = _describe(scan, path)
            layout = make_layout(tuple(run.channels.values()))
            pieces = _Pieces(layout)
            damaged = 0
            for records in _wanted(stream, scan, layout, window):
                if records is None:
                    damaged += 1
                else:
                    pieces.add(records)
    except OSError as error:
        raise RunLogError(f"Cannot read {path}: {error.strerror}.") from error
    t, arrays = pieces.join()
    return replace(
        run,
        t=t,
        arrays=MappingProxyType(arrays),
        complete=scan.complete and not damaged,
        note=" ".join(filter(None, (_ending(scan, path), _damage(damaged, path), run.note))),
    )


def _make_window(start: float | None, stop: float | None, stride: int) -> _Window:
    if stride < 1 or stride != int(stride):
        raise InputError("A stride is a whole number from 1 on", given=stride)
    window = _Window(
        -np.inf if start is None else float(start), np.inf if stop is None else float(stop), stride
    )
    if not window.start <= window.stop:
        raise InputError("A window starts before it stops", given=(start, stop))
    return window


def _find_log(place: Path) -> Path:
    path = place / LOG_NAME if place.is_dir() else place
    if path.is_file():
        return path
    if place.is_dir():
        inside = sorted(entry.name for entry in place.iterdir())[:8]
        held = f"it holds {', '.join(inside)}" if inside else "it is empty"
        raise RunLogError(f"There is no {LOG_NAME} in {place}; {held}. Give the folder of one run.")
    if place.parent.is_dir():
        runs = sorted(entry.parent.name for entry in place.parent.glob(f"*/{LOG_NAME}"))[-8:]
        beside = f" Beside it there are runs: {', '.join(runs)}." if runs else ""
        raise RunLogError(f"There is no run at {place}.{beside}")
    raise RunLogError(f"There is no run at {place}, and no folder {place.parent} either.")


def _describe(scan: Scan, path: Path) -> Run:
    """Build the run without its ticks from the metadata at the start of the log."""
    about = scan.metadata.get("equipoise.run")
    if about is None:
        if scan.chunks or scan.complete:
            raise RunLogError(
                f"{path} is an MCAP file but not a log of Equipoise. "
                "Other tools (mcap, Foxglove, PlotJuggler) may open it."
            )
        raise cut_off_early(path)
    if about.get("format") != FORMAT:
        raise RunLogError(
            f"{path} has format {about.get('format')!r}; this version reads {FORMAT!r}. "
            "Read it with the version of Equipoise that wrote it."
        )
    try:
        channels = {channel.name: channel for channel in channels_from_json(about["channels"])}
        seed, scenario = int(about["seed"]), about["scenario"]
    except (KeyError, TypeError, ValueError, EquipoiseError) as error:
        raise RunLogError(f"{path} is damaged: its channels cannot be read ({error}).") from error
    summary, note = _summary(path.parent)
    return Run(
        folder=path.parent,
        t=np.empty(0),
        arrays={},
        channels=MappingProxyType(channels),
        scenario_text=scenario,
        seed=seed,
        info=MappingProxyType(scan.metadata.get("equipoise.info", {})),
        summary=summary,
        complete=False,
        note=note,
    )


def _summary(folder: Path) -> tuple[dict[str, Any] | None, str]:
    if not (folder / SUMMARY_NAME).exists():
        return None, ""
    try:
        return read_summary(folder), ""
    except RunLogError as error:
        return None, str(error)


def _wanted(
    stream: BinaryIO, scan: Scan, layout: TickLayout, window: _Window
) -> Iterator[np.ndarray | None]:
    """Yield the wanted records of each chunk; None for a chunk that is damaged."""
    last, skip = -np.inf, 0
    for chunk in scan.chunks:
        if chunk.last < window.start - _MARGIN or chunk.first >= window.stop + _MARGIN:
            continue
        content = read_chunk(stream, chunk)
        records = None if content is None else layout.view(content)
        if records is None or not _increasing(records["t"], last):
            yield None
            continue
        last = records["t"][-1] if records.size else last
        first, end = np.searchsorted(records["t"], (window.start, window.stop))
        inside = records[first:end]
        yield inside[skip :: window.stride]
        skip = (skip - inside.size) % window.stride


def _increasing(times: np.ndarray, last: float) -> bool:
    return not times.size or bool(times[0] > last and np.all(times[1:] > times[:-1]))


class _Pieces:
    """The numbers of each channel, chunk by chunk, until they are joined."""

    def __init__(self, layout: TickLayout) -> None:
        self._layout = layout
        self._times: list[np.ndarray] = [np.empty(0)]
        self._values: list[list[np.ndarray]] = [
            [np.empty((0, channel.size))] for channel in layout.channels
        ]

    def add(self, records: np.ndarray) -> None:
        """Copy the numbers out of (n,) records."""
        self._times.append(records["t"].copy())
        for i, pieces in enumerate(self._values):
            pieces.append(records[f"values{i}"].copy())

    def join(self) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Return times (N,) and arrays (N, k), read-only; a piece is released once copied."""
        arrays: dict[str, np.ndarray] = {}
        for channel, pieces in zip(self._layout.channels, self._values, strict=True):
            arrays[channel.name] = _frozen(pieces)
            pieces.clear()
        return _frozen(self._times), arrays


def _frozen(pieces: list[np.ndarray]) -> np.ndarray:
    joined = np.concatenate(pieces)
    joined.flags.writeable = False
    return joined


def _ending(scan: Scan, path: Path) -> str:
    if scan.complete:
        return ""
    until = f"up to t = {scan.chunks[-1].last:.6g} s" if scan.chunks else "without a tick"
    return f"{path.name} breaks off (the run was killed, or still runs): loaded {until}."


def _damage(damaged: int, path: Path) -> str:
    if not damaged:
        return ""
    return f"{path.name} is damaged: {damaged} chunk{'s' * (damaged > 1)} had to be left out."
