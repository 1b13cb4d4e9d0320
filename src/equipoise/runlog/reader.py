"""Reading a run back, whole or in pieces, finished or cut off."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, BinaryIO

import numpy as np

from equipoise.errors import EquipoiseError, InputError, RunLogError
from equipoise.runlog.channels import Channel, channels_from_json
from equipoise.runlog.checksums import damaged_texts
from equipoise.runlog.folders import LOG_NAME, SUMMARY_NAME, read_summary
from equipoise.runlog.layout import TickLayout, make_layout
from equipoise.runlog.losses import TOLD, Losses
from equipoise.runlog.run import Run
from equipoise.runlog.scan import Scan, cut_off_early, read_chunk, scan_log
from equipoise.runlog.writer import FORMAT

UNCHECKED, UNNAMED = "1", "2"  # formats without checksums, and without names of numbers
_MARGIN = 1e-6  # [s], as a chunk's times are rounded to nanoseconds
CHECKED_WHOLE = 1 << 28  # [bytes] up to which a log is read once more to know that it is whole


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
    long log can be read in pieces. A log that was cut off or damaged gives what is left of it;
    `complete` is then False and `note` says what is missing. Ticks are numbered, so that a gap is
    noticed at either side of the window too.

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
            layout = layout_of(scan, tuple(run.channels.values()))
            pieces, losses = _Pieces(layout), Losses()
            for records in _wanted(stream, scan, layout, window, losses):
                pieces.add(records)
    except OSError as error:
        raise RunLogError(f"Cannot read {path}: {error.strerror}.") from error
    t, arrays = pieces.join()
    return replace(
        run,
        t=t,
        arrays=MappingProxyType(arrays),
        complete=scan.complete and run.complete and not losses,
        note=" ".join(filter(None, (_ending(scan, path), losses.sentence(path.name), run.note))),
    )


def check_log(folder_or_mcap: Path | str, *, at_most: float = np.inf) -> str:
    """Read a whole log without keeping it; return what is wrong with it, "" if nothing is.

    Of a log longer than `at_most` [bytes] it is said what can be told without reading it.
    Raises: RunLogError as `load_run`.
    """
    try:
        path = _find_log(Path(folder_or_mcap))
        if path.stat().st_size > at_most:
            return load_run(path, start=-1.0, stop=-1.0).note
        with open(path, "rb") as stream:
            scan = scan_log(stream, path)
            run = _describe(scan, path)
            layout, losses = layout_of(scan, tuple(run.channels.values())), Losses()
            for _ in _wanted(stream, scan, layout, _Window(-np.inf, np.inf, 1), losses):
                pass
            losses.pictures += sum(read_chunk(stream, chunk) is None for chunk in scan.pictures)
    except OSError as error:
        raise RunLogError(f"Cannot read {path}: {error.strerror}.") from error
    return " ".join(filter(None, (_ending(scan, path), losses.sentence(path.name), run.note)))


def layout_of(scan: Scan, channels: tuple[Channel, ...]) -> TickLayout:
    """Return the layout of the ticks of a log that was scanned."""
    about = scan.metadata.get("equipoise.run", {})
    return make_layout(channels, named=about.get("format") not in (UNCHECKED, UNNAMED))


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
        runs = sorted(entry.parent.name for entry in place.glob(f"*/{LOG_NAME}"))[-8:]
        held = f"; it holds {', '.join(runs)}" if runs else ""
        if not any(place.iterdir()):
            held = "; it is empty"
        raise RunLogError(f"There is no {LOG_NAME} in {place}{held}. Give the folder of one run.")
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
    if about.get("format") not in (UNCHECKED, UNNAMED, FORMAT):
        raise RunLogError(
            f"{path} has format {about.get('format')!r}; this version reads {FORMAT!r}. "
            "Read it with the version of Equipoise that wrote it."
        )
    try:
        channels = {channel.name: channel for channel in channels_from_json(about["channels"])}
        seed, scenario = int(about["seed"]), about["scenario"]
    except (KeyError, TypeError, ValueError, EquipoiseError) as error:
        raise RunLogError(f"{path} is damaged: its channels cannot be read ({error}).") from error
    spoilt = damaged_texts(scan.metadata) if about["format"] != UNCHECKED else []
    summary, note = _summary(path.parent)
    if spoilt:
        note = f"{_spoilt_texts(path.name, spoilt)} {note}".strip()
    return Run(
        folder=path.parent,
        t=np.empty(0),
        arrays={},
        channels=MappingProxyType(channels),
        scenario_text=scenario,
        seed=seed,
        info=MappingProxyType(scan.metadata.get("equipoise.info", {})),
        summary=summary,
        complete=not spoilt,
        note=note,
    )


def _spoilt_texts(name: str, spoilt: list[str]) -> str:
    """Say which texts of a log are not what was written."""
    named = ", ".join(one.removeprefix("equipoise.") for one in spoilt[:TOLD])
    more = f" and {len(spoilt) - TOLD} more" if len(spoilt) > TOLD else ""
    return (
        f"{name} is damaged: what it says of itself ({named}{more}) does not match its checksum. "
        "Names, units or the scenario may be wrong."
    )


def _summary(folder: Path) -> tuple[dict[str, Any] | None, str]:
    if not (folder / SUMMARY_NAME).exists():
        return None, ""
    try:
        return read_summary(folder), ""
    except RunLogError as error:
        return None, str(error)


def _wanted(
    stream: BinaryIO, scan: Scan, layout: TickLayout, window: _Window, losses: Losses
) -> Iterator[np.ndarray]:
    """Yield the wanted records of each chunk that can be read; note what is lost.

    The ticks of a log are numbered from 0 on. A chunk on either side of the window is read too, so
    that a gap at its edge is noticed.
    """
    first, end = _chunks_around(scan, window)
    last, skip, number = -np.inf, 0, 0 if first == 0 else None
    for chunk in scan.chunks[first:end]:
        content = read_chunk(stream, chunk)
        records = None if content is None else layout.view(content)
        if records is None or not _increasing(records["t"], last):
            losses.chunks += 1
            continue
        if not records.size:
            continue
        numbers = records["sequence"].astype(np.int64)
        if numbers.size > 1 and numbers[0] == numbers[-1]:  # another tool wrote it: no numbers
            number = None
        losses.misplaced += int(abs(records["t"][0] - chunk.first) > _MARGIN)
        _note_gaps(numbers, records["t"], number, last, losses)
        last = float(records["t"][-1])
        number = int(numbers[-1]) + 1 if numbers.size == 1 or numbers[0] < numbers[-1] else None
        start, stop = np.searchsorted(records["t"], (window.start, window.stop))
        inside = records[start:stop]
        yield inside[skip :: window.stride]
        skip = (skip - inside.size) % window.stride
    if end == len(scan.chunks) and scan.messages is not None and number is not None:
        losses.at_end = max(scan.messages - number, 0)
    if not losses and scan.lost:
        losses.gaps += [(lost.ticks, lost.first, lost.last) for lost in scan.lost]


def _chunks_around(scan: Scan, window: _Window) -> tuple[int, int]:
    """Return the range of chunks that hold the window, and one more on either side."""
    inside = [
        k
        for k, chunk in enumerate(scan.chunks)
        if chunk.last >= window.start - _MARGIN and chunk.first < window.stop + _MARGIN
    ]
    if not inside:
        return 0, 0
    return max(inside[0] - 1, 0), min(inside[-1] + 2, len(scan.chunks))


def _note_gaps(
    numbers: np.ndarray, times: np.ndarray, expected: int | None, last: float, losses: Losses
) -> None:
    """Note where the numbers of ticks leave some out; the first one should be `expected`."""
    if expected is not None and numbers[0] > expected:
        losses.gaps.append((int(numbers[0]) - expected, last, float(times[0])))
    for k in np.flatnonzero(np.diff(numbers) > 1):
        losses.gaps.append(
            (int(numbers[k + 1] - numbers[k]) - 1, float(times[k]), float(times[k + 1]))
        )


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
            pieces.append(self._layout.values(records, i).copy())

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
    if scan.closed:
        return f"{path.name} is damaged inside: what follows cannot be found. Loaded {until}."
    return f"{path.name} breaks off (the run was killed, or still runs): loaded {until}."
