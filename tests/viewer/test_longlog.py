"""Single ticks and pieces of a log, against the reader that loads it whole."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from viewer_logs import write_sway

pytest.importorskip("viser", reason="needs the extra 'viewer': pip install -e '.[viewer]'")

from equipoise.errors import RunLogError
from equipoise.runlog import load_run
from equipoise.viewer.longlog import LongLog


def test_a_tick_is_what_the_reader_gives(sway: Path, rng: np.random.Generator) -> None:
    log, run = LongLog(sway), load_run(sway)
    assert (log.t_first, log.t_last) == (run.t[0], run.t[-1])
    for t in rng.uniform(-0.1, 1.1, size=60):
        before = np.flatnonzero(run.t <= max(t, run.t[0]))[-1]
        tick = log.at(t)
        assert tick.t == run.t[before]
        for name in run:
            assert np.array_equal(tick.values[name], run[name][before])


def test_neighbours_are_one_tick_away_also_across_chunks(sway: Path) -> None:
    log, run = LongLog(sway), load_run(sway)
    for k in range(0, len(run.t) - 1):
        assert log.after(run.t[k]).t == run.t[k + 1]
        assert log.before(run.t[k + 1]).t == run.t[k]
    assert log.after(run.t[-1]).t == run.t[-1]
    assert log.before(run.t[0]).t == run.t[0]


def test_opening_costs_the_same_however_long_the_log_is(sway: Path, tmp_path: Path) -> None:
    short, long = LongLog(write_sway(tmp_path / "short", 60)), LongLog(sway)
    assert long.chunk_count > 5 * short.chunk_count
    assert long.chunks_read == short.chunks_read == 2
    long.at(0.5)
    assert long.chunks_read == 3


def test_pieces_hold_every_tick_once_coarse_first(sway: Path) -> None:
    log, run = LongLog(sway), load_run(sway)
    passes, times = zip(*((n, a["t"].copy()) for n, a in log.pieces((8, 2, 1))), strict=True)
    assert list(passes) == sorted(passes)
    assert set(passes) == {0, 1, 2}
    assert np.array_equal(np.sort(np.concatenate(times)), run.t)
    coarse = np.concatenate([t for n, t in zip(passes, times, strict=True) if n == 0])
    assert coarse.min() == run.t[0]
    assert coarse.max() == run.t[-1]
    assert len(coarse) < len(run.t) / 4


def test_a_log_that_breaks_off_is_shown_as_far_as_it_goes(sway: Path, tmp_path: Path) -> None:
    cut = tmp_path / "cut"
    cut.mkdir()
    content = (sway / "run.mcap").read_bytes()
    (cut / "run.mcap").write_bytes(content[: len(content) // 2])
    log, whole = LongLog(cut), LongLog(sway)
    assert "breaks off" in log.run.note
    assert 0.1 < log.t_last < whole.t_last
    assert np.array_equal(log.at(0.05).values["q"], whole.at(0.05).values["q"])


def test_a_damaged_chunk_is_stepped_over(sway: Path, tmp_path: Path) -> None:
    hurt = tmp_path / "hurt"
    shutil.copytree(sway, hurt)
    content = bytearray((hurt / "run.mcap").read_bytes())
    place = LongLog(sway)._chunks[5]
    middle = place.offset + place.length // 2
    content[middle : middle + 40] = bytes(40)
    (hurt / "run.mcap").write_bytes(bytes(content))
    log = LongLog(hurt)
    inside = (place.first + place.last) / 2.0
    assert log.at(inside).t < place.first
    assert log.after(place.first - 1e-6).t > place.last


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "is empty"),
        (b"GIF89a, nothing of ours", "is not an MCAP file"),
        (b"\x89MCAP0\r\n", "breaks off within its first records"),
    ],
)
def test_what_is_no_log_gets_a_sentence(tmp_path: Path, content: bytes, said: str) -> None:
    (tmp_path / "run.mcap").write_bytes(content)
    with pytest.raises(RunLogError, match=said):
        LongLog(tmp_path)


def test_a_log_without_ticks_gets_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(RunLogError, match="holds no tick"):
        LongLog(write_sway(tmp_path / "none", 0))
