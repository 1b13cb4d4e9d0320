"""A log that was cut, killed or spoilt gives what is left of it, or a sentence; never a crash."""

from __future__ import annotations

import os
import signal
import struct
import subprocess
import sys
import textwrap
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.writer import Writer
from mcap_protobuf.decoder import DecoderFactory

import equipoise.runlog.writer as writer_module
from equipoise.errors import RunLogError
from equipoise.runlog import Channel, Run, RunWriter, check_log, load_run
from equipoise.runlog.folders import write_summary
from equipoise.runlog.layout import make_layout


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """Give a whole run of 300 random ticks."""
    folder = tmp_path_factory.mktemp("whole")
    generator = np.random.default_rng(0)
    channels = [Channel("q", tuple("abcde"), "m"), Channel("f", ("x",), "N")]
    with RunWriter(folder, channels, scenario_text="a: 1\n", seed=5) as writer:
        for i in range(300):
            writer.write(i * 1e-3, {"q": generator.normal(size=5), "f": np.array([float(i)])})
    return load_run(folder)


@pytest.fixture(scope="module")
def chunks(log: Run) -> list[tuple[int, int]]:
    """Give (end [bytes], ticks so far) of each chunk, as an independent reader sees them."""
    ends, ticks = [], 0
    with open(log.folder / "run.mcap", "rb") as stream:
        for index in make_reader(stream).get_summary().chunk_indexes:
            ticks += round((index.message_end_time - index.message_start_time) / 1e6) + 1
            ends.append((index.chunk_start_offset + index.chunk_length, ticks))
    assert ends[-1][1] == 300
    return ends


@given(share=st.floats(0.0, 1.0))
@settings(max_examples=80, deadline=None)
def test_cut_anywhere_all_whole_chunks_are_read(
    log: Run, chunks: list[tuple[int, int]], share: float
) -> None:
    content = (log.folder / "run.mcap").read_bytes()
    cut = int(share * len(content))
    wanted = max([ticks for end, ticks in chunks if end <= cut], default=0)
    piece = log.folder / "piece.mcap"
    piece.write_bytes(content[:cut])
    try:
        run = load_run(piece)
    except RunLogError:
        assert wanted == 0
        return
    assert run.t.size == wanted
    assert np.array_equal(run["q"], log["q"][:wanted])
    assert run.complete == (cut == len(content))
    assert run.complete or "breaks off" in run.note
    assert (run.scenario_text, run.seed) == ("a: 1\n", 5)


@given(position=st.floats(0.0, 1.0, exclude_max=True), bit=st.integers(0, 7))
@settings(max_examples=150, deadline=None)
def test_a_flipped_bit_never_changes_a_number(log: Run, position: float, bit: int) -> None:
    """Every number that is read is one that was written at that time; the rest is left out."""
    content = bytearray((log.folder / "run.mcap").read_bytes())
    content[int(position * len(content))] ^= 1 << bit
    spoilt = log.folder / "spoilt.mcap"
    spoilt.write_bytes(content)
    try:
        run = load_run(spoilt)
    except RunLogError:
        return
    if (dict(run.channels), run.scenario_text, run.seed, dict(run.info)) != (
        dict(log.channels), log.scenario_text, log.seed, dict(log.info)
    ):  # fmt: skip
        assert not run.complete
        assert "does not match its checksum" in run.note
        return
    where = np.searchsorted(log.t, run.t)
    assert np.array_equal(run.t, log.t[where])
    assert np.array_equal(run["q"], log["q"][where])
    assert run.t.size == 300 or not run.complete


def test_a_spoilt_chunk_is_left_out_and_said(log: Run, chunks: list[tuple[int, int]]) -> None:
    content = bytearray((log.folder / "run.mcap").read_bytes())
    (_, before), (end, after) = chunks[2:4]
    content[end - 40] ^= 0xFF
    spoilt = log.folder / "spoilt.mcap"
    spoilt.write_bytes(content)
    run = load_run(spoilt)
    assert not run.complete
    assert "1 chunk had to be left out" in run.note
    assert np.array_equal(run["f"][:, 0], np.delete(log["f"][:, 0], np.arange(before, after)))


def records_of(content: bytes) -> list[tuple[int, int, int]]:
    """Return opcode, place [bytes] and length of each record, as the MCAP specification has it."""
    found, at = [], 8
    while at + 9 <= len(content) - 8:
        opcode, length = struct.unpack_from("<BQ", content, at)
        found.append((opcode, at, length))
        at += 9 + length
    return found


CHUNK, INDEX = 6, 7


@pytest.mark.parametrize("which", [0, 3, -1])
def test_a_chunk_that_is_no_longer_recognised_is_missed(log: Run, which: int) -> None:
    """One bit of its opcode: its ticks are gone, and their number is told, also for a window."""
    content = bytearray((log.folder / "run.mcap").read_bytes())
    chunks = [at for opcode, at, _ in records_of(content) if opcode == CHUNK]
    content[chunks[which]] ^= 1
    spoilt = log.folder / "spoilt.mcap"
    spoilt.write_bytes(content)
    run = load_run(spoilt)
    lost = np.setdiff1d(log.t, run.t)
    assert lost.size
    assert not run.complete
    assert f"{lost.size} tick" in run.note
    assert check_log(spoilt) == run.note
    around = load_run(spoilt, start=lost[0] - 1e-6, stop=lost[-1] + 1e-6)
    assert not around.complete
    assert f"{lost.size} tick" in around.note
    assert f"{lost.size} tick" in load_run(spoilt, start=-1.0, stop=-1.0).note  # no chunk is read


def test_ticks_cut_out_of_the_middle_are_missed_by_their_numbers(log: Run) -> None:
    """A chunk with its index cut out of an unfinished log: nothing but the numbers tells."""
    content = (log.folder / "run.mcap").read_bytes()
    records = records_of(content)
    chunks = [(at, length) for opcode, at, length in records if opcode == CHUNK]
    first, after = chunks[3][0], chunks[4][0]
    spoilt = log.folder / "spoilt.mcap"
    spoilt.write_bytes(content[:first] + content[after : chunks[6][0]])
    run = load_run(spoilt)
    lost = log.t[(log.t < run.t[-1]) & ~np.isin(log.t, run.t)]
    before, behind = run.t[run.t < lost[0]][-1], run.t[run.t > lost[-1]][0]
    told = f"{lost.size} ticks are missing between t = {before:.6g} s and t = {behind:.6g} s"
    assert told in run.note


@given(share=st.floats(0.0, 1.0, exclude_max=True), bit=st.integers(0, 7))
@settings(max_examples=80, deadline=None)
def test_a_changed_label_or_scenario_is_noticed(log: Run, share: float, bit: int) -> None:
    """Wherever a bit of the opening texts changes, the log is refused or says so."""
    content = bytearray((log.folder / "run.mcap").read_bytes())
    texts = [(at, length) for opcode, at, length in records_of(content) if opcode == 12]
    first, end = texts[0][0] + 9, texts[-1][0] + 9 + texts[-1][1]
    content[first + int(share * (end - first))] ^= 1 << bit
    spoilt = log.folder / "spoilt.mcap"
    spoilt.write_bytes(content)
    try:
        run = load_run(spoilt)
    except RunLogError:
        return
    if run.complete:  # a length that reaches beyond the record hurts nothing
        assert (run.scenario_text, run.seed) == (log.scenario_text, log.seed)
        assert (dict(run.channels), dict(run.info)) == (dict(log.channels), dict(log.info))
    else:
        assert run.note


@given(st.binary(max_size=200))
@settings(max_examples=60, deadline=None)
def test_noise_after_the_magic_is_refused(log: Run, noise: bytes) -> None:
    place = log.folder / "noise.mcap"
    place.write_bytes(b"\x89MCAP0\r\n" + noise)
    with pytest.raises(RunLogError):
        load_run(place)


def test_files_that_are_no_logs_are_named(tmp_path: Path) -> None:
    place = tmp_path / "run.mcap"
    place.write_bytes(b"")
    with pytest.raises(RunLogError, match="is empty"):
        load_run(tmp_path)
    place.write_bytes(b"hello, world")
    with pytest.raises(RunLogError, match="not an MCAP file"):
        load_run(tmp_path)
    place.write_bytes(b"\x89MC")
    with pytest.raises(RunLogError, match="breaks off"):
        load_run(tmp_path)
    with open(place, "wb") as stream:
        foreign = Writer(stream)
        foreign.start()
        foreign.finish()
    with pytest.raises(RunLogError, match="not a log of Equipoise"):
        load_run(tmp_path)


def test_missing_runs_are_explained(tmp_path: Path, write: Callable) -> None:
    with pytest.raises(RunLogError, match="it is empty"):
        load_run(tmp_path)
    write(tmp_path / "reach-1", 3)
    with pytest.raises(RunLogError, match=r"it holds reach-1\. Give the folder of one run"):
        load_run(tmp_path)
    with pytest.raises(RunLogError, match="there are runs: reach-1"):
        load_run(tmp_path / "reach-2")
    with pytest.raises(RunLogError, match="no folder"):
        load_run(tmp_path / "nowhere" / "reach")


@pytest.mark.skipif(os.geteuid() == 0, reason="nothing is forbidden to root")
def test_a_forbidden_log_is_named(tmp_path: Path, write: Callable) -> None:
    write(tmp_path, 3)
    (tmp_path / "run.mcap").chmod(0)
    with pytest.raises(RunLogError, match="Permission denied"):
        load_run(tmp_path)


def test_a_log_of_another_format_is_refused(tmp_path: Path, write: Callable) -> None:
    write(tmp_path, 3)
    log = tmp_path / "run.mcap"
    entry = b"\x06\x00\x00\x00format\x01\x00\x00\x00"
    content = log.read_bytes()
    assert content.count(entry + b"3") == 1
    log.write_bytes(content.replace(entry + b"3", entry + b"4"))
    with pytest.raises(RunLogError, match="has format '4'"):
        load_run(tmp_path)


@pytest.mark.parametrize("version", ["1", "2"])
def test_logs_of_older_versions_are_read(
    tmp_path: Path, write: Callable, monkeypatch: pytest.MonkeyPatch, version: str
) -> None:
    """Before format 3 a channel was a list of doubles, before format 2 there were no checksums."""
    monkeypatch.setattr(writer_module, "FORMAT", version)
    monkeypatch.setattr(writer_module, "make_layout", partial(make_layout, named=False))
    ticks = write(tmp_path, 50)
    run = load_run(tmp_path)
    assert (run.t.size, run.complete, run.note, check_log(tmp_path)) == (50, True, "", "")
    for name, values in run.arrays.items():
        assert np.array_equal(values, [tick[name] for tick in ticks])
    with open(tmp_path / "run.mcap", "rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        decoded = [tick for *_, tick in reader.iter_decoded_messages()]
    assert [list(tick.q) for tick in decoded] == run["q"].tolist()


def test_a_spoilt_summary_does_not_hide_the_run(tmp_path: Path, write: Callable) -> None:
    write(tmp_path, 3)
    write_summary(tmp_path, {"error": float("inf")})
    assert load_run(tmp_path).summary == {"error": float("inf")}
    (tmp_path / "summary.json").write_text('{"error": ')
    run = load_run(tmp_path)
    assert run.summary is None
    assert run.t.size == 3
    assert "not valid JSON" in run.note


def test_a_log_can_be_read_while_it_is_written(tmp_path: Path) -> None:
    with RunWriter(tmp_path, [Channel("q", ("x",), "m")], scenario_text="", seed=0) as writer:
        for i in range(50):
            writer.write(i * 0.01, {"q": np.array([float(i)])})
        writer.flush()
        run = load_run(tmp_path)
        assert run.t.size == 50
        assert not run.complete
    assert load_run(tmp_path).complete


KILLED = textwrap.dedent(
    """
    import sys, time
    import numpy as np
    from pathlib import Path
    from equipoise.runlog import Channel, RunWriter
    writer = RunWriter(Path(sys.argv[1]), [Channel("q", tuple("abc"), "m")],
                       scenario_text="a: 1", seed=1)
    begin, last = time.perf_counter(), -1.0
    while True:
        t = (time.perf_counter() - begin) * float(sys.argv[2])
        if t <= last:
            continue
        writer.write(t, {"q": np.full(3, t)})
        last = t
        print(repr(t), flush=True)
        time.sleep(0.001)
    """
)


@pytest.mark.parametrize("speed", [1.0, 20.0, 0.01])
def test_a_killed_run_loses_less_than_half_a_second(tmp_path: Path, speed: float) -> None:
    """kill -9 in full run, at real time, faster and slower: what was told is on the disk."""
    with subprocess.Popen(
        [sys.executable, "-c", KILLED, str(tmp_path), str(speed)],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
    ) as process:
        told = []
        for line in process.stdout:
            told.append(float(line))
            if told[-1] > 0.8 * speed:  # long enough that losing everything would be noticed
                os.kill(process.pid, signal.SIGKILL)
    run = load_run(tmp_path)
    assert process.returncode == -signal.SIGKILL
    assert not run.complete
    assert np.array_equal(run["q"], np.repeat(run.t[:, None], 3, axis=1))
    count = min(run.t.size, len(told))
    assert np.array_equal(run.t[:count], told[:count])
    assert told[-1] - run.t[-1] <= 0.5 * min(speed, 1.0)
