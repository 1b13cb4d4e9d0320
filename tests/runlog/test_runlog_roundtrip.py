"""What was written is what is read, to the last bit, and any other reader agrees."""

from __future__ import annotations

import csv
import json
import tempfile
import zlib
from collections.abc import Callable
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
import zstandard
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import Chunk, Footer, Message, MessageIndex, SummaryOffset
from mcap.writer import CompressionType, Writer
from mcap_protobuf.decoder import DecoderFactory

from equipoise.errors import InputError, NameNotFoundError, NonFiniteError
from equipoise.runlog import (
    Channel,
    RunWriter,
    export_csv,
    export_npz,
    load_run,
)
from equipoise.runlog.layout import make_layout
from equipoise.runlog.packing import TickBuffer

ANY_BITS = st.integers(0, 2**64 - 1)


@given(st.lists(st.tuples(ANY_BITS, ANY_BITS, ANY_BITS), min_size=1, max_size=40))
@settings(max_examples=30, deadline=None)
def test_every_bit_pattern_survives(patterns: list[tuple[int, int, int]]) -> None:
    """Signed zeros, subnormals, infinities and NaNs with any payload come back unchanged."""
    wanted = np.array(patterns, dtype=np.uint64).view(np.float64)
    channels = [Channel("a", ("x", "y"), "m"), Channel("b", ("z",), "N")]
    with tempfile.TemporaryDirectory() as place:
        with RunWriter(Path(place), channels, scenario_text="", seed=0) as writer:
            for i, row in enumerate(wanted):
                writer.write(i * 0.01, {"a": row[:2], "b": row[2:]})
        run = load_run(place)
    got = np.hstack([run["a"], run["b"]])
    assert np.array_equal(got.view(np.uint64), wanted.view(np.uint64))


def test_run_tells_what_it_was(tmp_path: Path, write: Callable) -> None:
    write(tmp_path / "run", 50, seed=7)
    run = load_run(tmp_path / "run")
    assert run.complete
    assert run.note == ""
    assert run.summary is None
    assert run.seed == 7
    assert run.scenario_text == "robot: hrp2\n"
    assert (tmp_path / "run" / "scenario.yaml").read_text() == run.scenario_text
    assert {"created", "equipoise", "numpy", "pinocchio", "python", "platform"} <= set(run.info)
    assert run.names == ("q", "lam/left_sole", "nothing", "s")
    assert run.channels["q"].units == ("m", "m", "rad")
    assert run.channels["q"].doc == "configuration"
    assert run["nothing"].shape == (50, 0)
    assert np.array_equal(run.t, np.arange(50) * 1e-3)
    assert "50 ticks" in repr(run)
    assert list(run) == list(run.names)


def test_arrays_are_read_only(tmp_path: Path, write: Callable) -> None:
    write(tmp_path, 3)
    run = load_run(tmp_path)
    with pytest.raises(ValueError, match="read-only"):
        run["q"][0, 0] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        run.t[0] = 1.0


def test_unknown_channel_offers_the_nearest(tmp_path: Path, write: Callable) -> None:
    write(tmp_path, 3)
    run = load_run(tmp_path)
    assert "lam/left_sole" in run
    assert "lam/left_sol" not in run
    with pytest.raises(NameNotFoundError, match="Did you mean 'lam/left_sole'"):
        run["lam/left_sol"]


def test_independent_reader_agrees(tmp_path: Path, write: Callable) -> None:
    """The plain MCAP and protobuf libraries, which know nothing of us, decode the same numbers."""
    write(tmp_path, 300)
    run = load_run(tmp_path)
    with open(tmp_path / "run.mcap", "rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        decoded = list(reader.iter_decoded_messages(topics=["/tick"]))
        summary = reader.get_summary()
        metadata = {entry.name: entry.metadata for entry in reader.iter_metadata()}
    assert len(decoded) == 300
    for i, (schema, channel, message, tick) in enumerate(decoded):
        assert (schema.name, channel.topic, message.sequence) == ("equipoise.Tick", "/tick", i)
        assert message.log_time == message.publish_time == i * 1_000_000
        assert tick.t == run.t[i]
        assert [tick.q.x, tick.q.y, tick.q.z] == list(run["q"][i])
        assert [tick.lam_left_sole.f_x, tick.lam_left_sole.f_y] == list(run["lam/left_sole"][i])
        assert tick.HasField("nothing")
        assert tick.s.s == run["s"][i, 0]
    assert summary.statistics.message_count == 300
    assert summary.statistics.chunk_count == len(summary.chunk_indexes) > 1
    assert metadata["equipoise.run"]["seed"] == "0"
    assert json.loads(metadata["equipoise.run"]["channels"])[0]["name"] == "q"


def test_our_bytes_are_what_protobuf_itself_writes(tmp_path: Path, write: Callable) -> None:
    """Encoding the decoded message again gives our bytes: the layout is protobuf's own."""
    write(tmp_path, 20)
    with open(tmp_path / "run.mcap", "rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for _, _, message, tick in list(reader.iter_decoded_messages())[1:]:  # t = 0 is left out
            assert tick.SerializeToString() == message.data


def test_every_entry_of_the_index_points_at_its_tick(tmp_path: Path, write: Callable) -> None:
    """Following summary, chunk index and message index byte by byte leads to each tick once."""
    write(tmp_path, 400)
    found = []
    with open(tmp_path / "run.mcap", "rb") as stream:
        for chunk_index in make_reader(stream).get_summary().chunk_indexes:
            stream.seek(chunk_index.chunk_start_offset + 9)
            chunk = Chunk.read(ReadDataStream(stream))
            content = zstandard.decompress(chunk.data)
            stream.seek(chunk_index.message_index_offsets[1] + 9)
            for time, offset in MessageIndex.read(ReadDataStream(stream)).records:
                message = Message.read(ReadDataStream(BytesIO(content[offset + 9 :])), 22)
                assert content[offset] == Opcode.MESSAGE
                assert message.log_time == time
                found.append(message.sequence)
    assert found == list(range(400))


def test_the_summary_is_where_the_footer_says(tmp_path: Path, write: Callable) -> None:
    """Footer, checksum and offsets of the groups, followed byte by byte."""
    write(tmp_path, 100)
    content = (tmp_path / "run.mcap").read_bytes()
    footer = Footer.read(ReadDataStream(BytesIO(content[-28:-8])))
    assert zlib.crc32(content[footer.summary_start : -12]) == footer.summary_crc
    offset, opcodes = footer.summary_offset_start, []
    while content[offset] == Opcode.SUMMARY_OFFSET:
        group = SummaryOffset.read(ReadDataStream(BytesIO(content[offset + 9 : offset + 26])))
        place, end = group.group_start, group.group_start + group.group_length
        while place < end:
            assert content[place] == group.group_opcode
            place += 9 + int.from_bytes(content[place + 1 : place + 9], "little")
        assert place == end
        opcodes.append(group.group_opcode)
        offset += 26
    assert content[offset] == Opcode.FOOTER
    assert len(set(opcodes)) == len(opcodes) == 5


@pytest.mark.parametrize("compression", list(CompressionType))
def test_a_log_rewritten_by_another_tool_is_read(
    tmp_path: Path, write: Callable, compression: CompressionType
) -> None:
    """Other compression, other chunks, definitions inside the chunks: the numbers stay."""
    write(tmp_path, 300)
    run, rewritten = load_run(tmp_path), tmp_path / "rewritten.mcap"
    _rewrite(tmp_path / "run.mcap", rewritten, compression, backwards=False)
    again = load_run(rewritten)
    assert again.complete
    assert np.array_equal(again.t, run.t)
    assert all(np.array_equal(again[name], run[name]) for name in run)


def test_a_log_that_runs_backwards_is_not_trusted(tmp_path: Path, write: Callable) -> None:
    write(tmp_path, 300)
    _rewrite(tmp_path / "run.mcap", tmp_path / "back.mcap", CompressionType.NONE, backwards=True)
    back = load_run(tmp_path / "back.mcap")
    assert not back.complete
    assert "damaged" in back.note
    assert np.all(np.diff(back.t) > 0.0)


def _rewrite(source: Path, target: Path, compression: CompressionType, *, backwards: bool) -> None:
    with open(source, "rb") as stream, open(target, "wb") as output:
        reader = make_reader(stream)
        writer = Writer(output, chunk_size=5000, compression=compression)
        writer.start()
        for entry in reader.iter_metadata():
            writer.add_metadata(entry.name, entry.metadata)
        found = list(reader.iter_messages())
        schema = writer.register_schema(
            found[0][0].name, found[0][0].encoding, data=found[0][0].data
        )
        channel = writer.register_channel("/tick", "protobuf", schema)
        for _, _, message in reversed(found) if backwards else found:
            writer.add_message(channel, message.log_time, message.data, message.publish_time)
        writer.finish()


def test_records_of_another_layout_are_not_taken_for_ours() -> None:
    """Equal length is not enough: (1, 3) doubles are not (2, 2) doubles."""
    wide = make_layout([Channel("a", ("x",), ""), Channel("b", ("x", "y", "z"), "")])
    even = make_layout([Channel("a", ("x", "y"), ""), Channel("b", ("x", "y"), "")])
    buffer = TickBuffer(wide, 3)
    for k in range(3):
        buffer.put_values(k, 1.0 + k, {"a": np.ones(1), "b": np.ones(3)})
    record = buffer.content(0, 1, 0).tobytes()
    assert wide.record.itemsize == even.record.itemsize == len(record)
    assert wide.view(record * 3).size == 3
    assert even.view(record) is None
    assert wide.view(record[:-1]) is None


@given(
    start=st.none() | st.floats(-0.1, 0.5),
    width=st.none() | st.floats(0.0, 0.5),
    stride=st.integers(1, 90),
)
@settings(max_examples=40, deadline=None)
def test_pieces_equal_slices_of_the_whole(
    start: float | None, width: float | None, stride: int
) -> None:
    stop = None if width is None else (start or 0.0) + width
    whole = _whole()
    piece = load_run(whole.folder, start=start, stop=stop, stride=stride)
    inside = (whole.t >= (-1.0 if start is None else start)) & (
        whole.t < (1.0 if stop is None else stop)
    )
    assert np.array_equal(piece.t, whole.t[inside][::stride])
    assert np.array_equal(piece["q"], whole["q"][inside][::stride])


_WHOLE: list = []


def _whole():
    """One log for all pieces; the folder lives as long as the tests."""
    if not _WHOLE:
        place = tempfile.TemporaryDirectory()
        channels = [Channel("q", ("x",), "m")]
        with RunWriter(Path(place.name), channels, scenario_text="", seed=0) as writer:
            for i in range(400):
                writer.write(i * 1e-3, {"q": np.array([float(i)])})
        _WHOLE.extend([load_run(place.name), place])
    return _WHOLE[0]


@pytest.mark.parametrize("window", [{"stride": 0}, {"stride": 1.5}, {"start": 2.0, "stop": 1.0}])
def test_windows_without_sense_are_refused(tmp_path: Path, write: Callable, window: dict) -> None:
    write(tmp_path, 3)
    with pytest.raises(InputError):
        load_run(tmp_path, **window)


def test_at_finds_the_nearest_tick(tmp_path: Path, write: Callable) -> None:
    write(tmp_path, 100, dt=0.01)
    run = load_run(tmp_path)
    generator = np.random.default_rng(1)
    for t in generator.uniform(-0.2, 1.2, size=200):
        assert abs(run.t[run.at(t)] - t) == np.min(np.abs(run.t - t))
    assert run.at(-np.inf) == 0
    assert run.at(np.inf) == 99
    with pytest.raises(NonFiniteError):
        run.at(np.nan)


def test_equal_runs_give_equal_npz_files(tmp_path: Path, write: Callable) -> None:
    for name in ("a", "b"):
        write(tmp_path / name, 80, seed=3)
        export_npz(load_run(tmp_path / name), tmp_path / f"{name}.npz")
    write(tmp_path / "c", 80, seed=4)
    export_npz(load_run(tmp_path / "c"), tmp_path / "c.npz")
    first, second, other = ((tmp_path / f"{name}.npz").read_bytes() for name in "abc")
    assert first == second
    assert first != other


def test_npz_holds_the_run(tmp_path: Path) -> None:
    channels = [Channel("file", ("x",), "m"), Channel("lam/left", ("y", "z"), "N")]
    with RunWriter(tmp_path, channels, scenario_text="", seed=0) as writer:
        for i in range(5):
            writer.write(i, {"file": [np.inf], "lam/left": [i, -0.0]})
    run = load_run(tmp_path)
    export_npz(run, tmp_path / "run.npz")
    with np.load(tmp_path / "run.npz") as loaded:
        assert set(loaded) == {"t", "file", "lam/left"}
        for name in ("file", "lam/left"):
            assert loaded[name].tobytes() == run[name].tobytes()
        assert loaded["t"].tobytes() == run.t.tobytes()


def test_csv_holds_the_run_to_the_last_bit(tmp_path: Path, write: Callable) -> None:
    write(tmp_path, 2500)
    run = load_run(tmp_path)
    export_csv(run, tmp_path / "run.csv")
    with open(tmp_path / "run.csv", newline="", encoding="utf-8") as stream:
        header, *rows = csv.reader(stream)
    assert header[:3] == ["t (s)", "q[x] (m)", "q[y] (m)"]
    assert header[-1] == "s[s]"
    wanted = np.hstack([run.t[:, None], *(run[name] for name in run.names)])
    assert np.array(rows, dtype=float).tobytes() == wanted.tobytes()


def test_channel_names_become_distinct_legal_fields(tmp_path: Path) -> None:
    """Names that protobuf (or its JSON form) would confuse still give a file others can read."""
    names = ["q_ref", "q/ref", "qRef", "Q REF", "9lives", "λ", "T", "_", "q_ref_n2", "класс"]
    channels = [Channel(name, ("x",), "") for name in names]
    with RunWriter(tmp_path, channels, scenario_text="", seed=0) as writer:
        writer.write(0.5, {name: np.array([float(i)]) for i, name in enumerate(names)})
    run = load_run(tmp_path)
    assert [run[name][0, 0] for name in names] == list(range(len(names)))
    with open(tmp_path / "run.mcap", "rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        ((*_, tick),) = reader.iter_decoded_messages()
    values = [value for field, value in tick.ListFields() if field.name != "t"]
    assert [value.x for value in values] == [float(i) for i in range(len(names))]
    assert all(field.name.isidentifier() for field, _ in tick.ListFields())


def test_many_channels_get_long_field_tags(tmp_path: Path) -> None:
    """Past field 15 and past 16 doubles protobuf's tags and lengths grow; nothing may shift."""
    channels = [Channel(f"c{i}", tuple(map(str, range(i))), "") for i in range(150)]
    tick = {f"c{i}": np.arange(i) + 1000.0 * i for i in range(150)}
    with RunWriter(tmp_path, channels, scenario_text="", seed=0) as writer:
        writer.write(1.0, tick)
    run = load_run(tmp_path)
    assert all(np.array_equal(run[name][0], values) for name, values in tick.items())
    with open(tmp_path / "run.mcap", "rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        ((*_, decoded),) = reader.iter_decoded_messages()
    for name, values in tick.items():
        told = {field.name: value for field, value in getattr(decoded, name).ListFields()}
        wanted = {f"x_{k}": value for k, value in enumerate(values) if value}
        assert told == wanted  # protobuf does not tell a zero
