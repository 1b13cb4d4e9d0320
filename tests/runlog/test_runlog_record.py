"""Ticks filled in place and written from one record are those written from a mapping."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from equipoise.errors import InputError, NameNotFoundError, RunLogError
from equipoise.runlog import RunWriter, load_run, mcapfile
from equipoise.runlog.channels import Channel

DT = 1e-3


def opened(folder: Path, channels: tuple[Channel, ...]) -> RunWriter:
    return RunWriter(folder, channels, scenario_text="robot: hrp2\n", seed=0)


def messages(folder: Path) -> list[bytes]:
    from mcap.reader import make_reader

    with open(folder / "run.mcap", "rb") as stream:
        return [message.data for *_, message in make_reader(stream).iter_messages()]


def test_both_ways_write_the_same_bytes(
    tmp_path: Path, write: Callable, channels: tuple[Channel, ...]
) -> None:
    ticks = write(tmp_path / "mapping", 100)
    with opened(tmp_path / "record", channels) as writer:
        views = writer.record.views
        for i, tick in enumerate(ticks):
            for name, values in tick.items():
                views[name][:] = values
            writer.write_record(i * DT)
    assert messages(tmp_path / "record") == messages(tmp_path / "mapping")


def test_both_ways_may_take_turns(tmp_path: Path, channels: tuple[Channel, ...]) -> None:
    sizes = {channel.name: channel.size for channel in channels}
    with opened(tmp_path, channels) as writer:
        for i in range(60):
            writer.record.numbers[:] = i
            if i % 3:
                writer.write_record(i * DT)
            else:
                writer.write(i * DT, {name: np.full(k, float(i)) for name, k in sizes.items()})
    run = load_run(tmp_path)
    assert all((run[name] == np.arange(60)[:, None]).all() for name in sizes)


def test_a_record_is_one_array_with_a_view_for_each_channel(
    tmp_path: Path, channels: tuple[Channel, ...]
) -> None:
    with opened(tmp_path, channels) as writer:
        record = writer.record
        assert record is writer.record
        assert np.isnan(record.numbers).all()
        assert tuple(record.views) == tuple(channel.name for channel in channels)
        for channel in channels:
            assert record[channel.name].shape == (channel.size,)
            assert record.numbers[record.places[channel.name]].shape == (channel.size,)
        for i, name in enumerate(record.views):
            record[name][:] = i
        writer.write_record(0.0)
        with pytest.raises(NameNotFoundError, match="lam/left_sole"):
            record["lam/left_sol"]
    wanted = np.repeat(np.arange(len(channels)), [channel.size for channel in channels])
    assert np.array_equal(record.numbers, wanted)
    assert all((load_run(tmp_path)[c.name] == i).all() for i, c in enumerate(channels))


def test_what_is_not_filled_is_nan_and_then_as_it_was(
    tmp_path: Path, channels: tuple[Channel, ...]
) -> None:
    with opened(tmp_path, channels) as writer:
        writer.record["q"][:] = 1.0
        writer.write_record(0.0)
        writer.record["s"][:] = 2.0
        writer.write_record(1.0)
    run = load_run(tmp_path)
    assert np.isnan(run["s"][0]).all()
    assert (run["q"] == 1.0).all()
    assert run["s"][1] == 2.0


def test_times_are_checked_as_ever(tmp_path: Path, channels: tuple[Channel, ...]) -> None:
    with opened(tmp_path, channels) as writer:
        writer.write_record(1.0)
        for t in (1.0, 0.5, np.nan):
            with pytest.raises(InputError, match=r"the last was at 1\.0 s"):
                writer.write_record(t)
    with pytest.raises(RunLogError, match="closed"):
        writer.write_record(2.0)
    assert list(load_run(tmp_path).t) == [1.0]


def test_interrupted_flushes_never_fill_the_buffer_over_its_end(
    tmp_path: Path, channels: tuple[Channel, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ctrl-C at every other flush, and a caller that goes on: no tick is lost, doubled or moved."""
    append, calls = mcapfile.McapFile.append, iter(range(10**6))

    def interrupted(file: mcapfile.McapFile, *chunk: np.ndarray) -> None:
        k = next(calls)
        if k % 4 == 1:
            raise KeyboardInterrupt
        append(file, *chunk)
        if k % 4 == 3:
            raise KeyboardInterrupt

    monkeypatch.setattr(mcapfile.McapFile, "append", interrupted)
    monkeypatch.setattr("equipoise.runlog.writer.CHUNK_BYTES", 1000)
    strikes = 0
    with opened(tmp_path, channels) as writer:
        for i in range(500):
            writer.record.numbers[:] = i
            t = i * DT
            while writer._last_time < t:
                try:
                    writer.write_record(t)
                except KeyboardInterrupt:
                    strikes += 1
        monkeypatch.undo()
    run = load_run(tmp_path)
    assert strikes > 10
    assert run.complete
    assert np.array_equal(run["q"][:, 0], np.arange(500.0))
