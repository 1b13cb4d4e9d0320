"""The writer takes what fits its channels, refuses the rest in words, and survives a full disk."""

from __future__ import annotations

import os
import subprocess
import sys
import textwrap
from collections.abc import Callable
from io import FileIO
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader

from equipoise.errors import InputError, NameNotFoundError, RunLogError, ShapeError
from equipoise.runlog import Channel, RunWriter, load_run, mcapfile

PAIR = [Channel("q", ("x", "y"), "m"), Channel("tau", ("x",), "N m")]
TICK = {"q": np.array([1.0, 2.0]), "tau": np.array([3.0])}


@pytest.fixture
def writer(tmp_path: Path):
    """Give an open writer for PAIR."""
    with RunWriter(tmp_path / "run", PAIR, scenario_text="", seed=0) as opened:
        yield opened


@pytest.mark.parametrize(
    ("values", "error", "words"),
    [
        ({**TICK, "taau": np.zeros(1)}, NameNotFoundError, "Did you mean 'tau'"),
        ({"q": TICK["q"]}, InputError, "Give tau too"),
        ({}, InputError, "Give q, tau too"),
        ({**TICK, "q": np.zeros(3)}, ShapeError, r"\(3,\), wanted \(2,\)"),
        ({**TICK, "q": np.zeros(1)}, ShapeError, r"\(1,\), wanted \(2,\)"),
        ({**TICK, "q": np.zeros((2, 3))}, ShapeError, r"\(2, 3\)"),
        ({**TICK, "q": np.zeros((2, 1, 1)), "tau": np.zeros((1, 2))}, ShapeError, r"\(2, 1, 1\)"),
        ({"q": np.zeros(1), "tau": np.zeros(2)}, ShapeError, r"\(1,\), wanted \(2,\)"),
        ({**TICK, "q": 1.0}, ShapeError, "channel 'q'"),
        ({**TICK, "q": np.array([1j, 0.0])}, InputError, "real numbers"),
        ({**TICK, "q": ["1", "2"]}, InputError, "real numbers"),
        ({**TICK, "q": [[1.0], [1.0, 2.0]]}, InputError, "one vector"),
        ({**TICK, "q": None}, InputError, "real numbers"),
    ],
)
def test_values_that_do_not_fit_are_refused(
    writer: RunWriter, values: dict, error: type[Exception], words: str
) -> None:
    """Nothing is broadcast, cut or guessed, and the log goes on as if nothing had happened."""
    writer.write(0.0, TICK)
    with pytest.raises(error, match=words):
        writer.write(1.0, values)
    writer.write(1.0, TICK)
    writer.close()
    assert list(load_run(writer.folder).t) == [0.0, 1.0]


def test_what_means_the_same_is_converted(writer: RunWriter) -> None:
    """Strided, reversed, integer, single-precision and listed values are logged as doubles."""
    grid = np.arange(12.0).reshape(3, 4)
    kinds = [grid[:2, 1], grid[0, 1::-1], np.array([4, 5]), np.float32([0.1, 0.2]), [6.0, 7.0]]
    for i, q in enumerate(kinds):
        writer.write(i, {"q": q, "tau": TICK["tau"]})
    writer.write(len(kinds), {"q": TICK["q"], "tau": 2.5})
    writer.close()
    run = load_run(writer.folder)
    assert np.array_equal(run["q"][:-1], np.array([np.asarray(q, dtype=float) for q in kinds]))
    assert run["tau"][-1, 0] == 2.5


def test_values_are_copied(writer: RunWriter) -> None:
    """A controller that reuses its buffers cannot change what was logged."""
    q = np.zeros(2)
    for i in range(5):
        q[:] = i
        writer.write(i * 1e-3, {"q": q, "tau": q[:1]})
    writer.close()
    assert np.array_equal(load_run(writer.folder)["q"][:, 0], np.arange(5.0))


@pytest.mark.parametrize("t", [-1e-9, np.nan, np.inf, 1e10])
def test_times_outside_the_clock_are_refused(writer: RunWriter, t: float) -> None:
    with pytest.raises(InputError, match="Time must be between"):
        writer.write(t, TICK)


@pytest.mark.parametrize("t", [0.5, 1.0, np.nan])
def test_time_must_increase(writer: RunWriter, t: float) -> None:
    writer.write(1.0, TICK)
    with pytest.raises(InputError, match=r"the last was at 1\.0 s"):
        writer.write(t, TICK)


def test_closing_twice_is_fine_and_writing_afterwards_is_not(writer: RunWriter) -> None:
    writer.write(0.0, TICK)
    writer.close()
    writer.close()
    with pytest.raises(RunLogError, match="closed"):
        writer.write(1.0, TICK)
    assert load_run(writer.folder).complete


def test_a_log_is_never_overwritten(tmp_path: Path, write: Callable) -> None:
    write(tmp_path, 10)
    before = (tmp_path / "run.mcap").read_bytes()
    with pytest.raises(RunLogError, match="already holds a log"):
        RunWriter(tmp_path, PAIR, scenario_text="", seed=0)
    assert (tmp_path / "run.mcap").read_bytes() == before


def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(RunLogError, match=r"Cannot write a log in .*file"):
        RunWriter(tmp_path / "file" / "run", PAIR, scenario_text="", seed=0)


@pytest.mark.skipif(os.geteuid() == 0, reason="nothing is forbidden to root")
def test_a_forbidden_folder_is_named(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    with pytest.raises(RunLogError, match="Permission denied"):
        RunWriter(tmp_path / "run", PAIR, scenario_text="", seed=0)


@pytest.mark.parametrize("channels", [[], [PAIR[0], PAIR[0]]])
def test_channels_must_exist_and_differ(tmp_path: Path, channels: list[Channel]) -> None:
    with pytest.raises(InputError):
        RunWriter(tmp_path, channels, scenario_text="", seed=0)


@pytest.mark.parametrize(
    "arguments",
    [
        ("t", ("x",), "m"),
        ("", ("x",), "m"),
        ("a\nb", ("x",), "m"),
        ("q", ("x", "x"), "m"),
        ("q", ("x", "y"), ("m",)),
        ("q", "xyz", "m"),
        ("q", (1, 2), "m"),
    ],
)
def test_channels_without_sense_are_refused(arguments: tuple) -> None:
    with pytest.raises(InputError):
        Channel(*arguments)


def test_an_exception_in_the_loop_leaves_a_whole_file(tmp_path: Path) -> None:
    def crash() -> None:
        with RunWriter(tmp_path, PAIR, scenario_text="", seed=0) as writer:
            for i in range(7):
                writer.write(i * 1e-3, TICK)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        crash()
    run = load_run(tmp_path)
    assert run.complete
    assert run.t.size == 7


@pytest.mark.parametrize("moment", ["before", "after", "beyond"])
def test_an_interrupt_within_a_flush_neither_loses_nor_doubles_ticks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, moment: str
) -> None:
    """Ctrl-C just before or after the bytes of a chunk reach the disk, or with more behind them."""
    write, interrupts = os.pwrite, iter([False, False, False, True])

    def interrupted(descriptor: int, block: bytes, offset: int) -> int:
        strike = next(interrupts, False)
        if strike and moment == "before":
            raise KeyboardInterrupt
        written = write(descriptor, block, offset)
        if strike and moment == "beyond":
            write(descriptor, b"?" * 10_000, offset + written)
        if strike:
            raise KeyboardInterrupt
        return written

    monkeypatch.setattr(mcapfile.os, "pwrite", interrupted)
    with pytest.raises(KeyboardInterrupt):
        _run_long(tmp_path)
    run = load_run(tmp_path)
    assert run.complete
    assert run.t.size > 2
    assert np.array_equal(run.t, np.arange(run.t.size) * 1e-2)


def test_an_interrupt_after_a_flush_doubles_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ctrl-C between noting a chunk as written and forgetting its ticks."""
    append = mcapfile.McapFile.append

    def interrupted(file: mcapfile.McapFile, *chunk: np.ndarray) -> None:
        append(file, *chunk)
        if file.ticks > 3:
            monkeypatch.undo()
            raise KeyboardInterrupt

    monkeypatch.setattr(mcapfile.McapFile, "append", interrupted)
    with pytest.raises(KeyboardInterrupt):
        _run_long(tmp_path)
    log = (tmp_path / "run.mcap").read_bytes()
    with open(tmp_path / "run.mcap", "rb") as stream:
        times = [message.log_time for *_, message in make_reader(stream).iter_messages()]
    assert log.endswith(mcapfile.MAGIC)
    assert times == [i * 10_000_000 for i in range(len(times))]
    assert list(load_run(tmp_path).t) == [i * 1e-2 for i in range(len(times))]


def test_a_full_disk_at_the_start_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(mcapfile, "_create", lambda path: FileIO("/dev/full", "wb"))
    with pytest.raises(RunLogError, match="No space left on device"):
        RunWriter(tmp_path, PAIR, scenario_text="", seed=0)


def test_a_disk_that_fills_up_keeps_what_was_safe(tmp_path: Path) -> None:
    """The kernel stops a file at 40 kB in the middle of a chunk; all earlier chunks are read."""
    script = textwrap.dedent(
        """
        import resource, sys
        import numpy as np
        from pathlib import Path
        from equipoise.errors import RunLogError
        from equipoise.runlog import Channel, RunWriter
        resource.setrlimit(resource.RLIMIT_FSIZE, (40_000, 40_000))
        generator = np.random.default_rng(0)
        errors = []
        with RunWriter(Path(sys.argv[1]), [Channel("q", tuple("abcdef"), "m")],
                       scenario_text="", seed=0) as writer:
            for i in range(2000):
                try:
                    writer.write(i * 1e-3, {"q": generator.normal(size=6)})
                except RunLogError as error:
                    errors.append(str(error))
        assert len(errors) > 2 and len(set(errors)) == 1, errors
        print(errors[0])
        """
    )
    done = _python(script, tmp_path)
    assert done.returncode == 0, done.stderr
    run = load_run(tmp_path)
    assert not run.complete
    assert run.t.size > 100
    assert np.array_equal(run["q"], np.random.default_rng(0).normal(size=(run.t.size, 6)))
    assert f"safe up to t = {run.t[-1]:.6g} s ({run.t.size} ticks)" in done.stdout
    assert "run.mcap" in done.stdout
    content, offset = (tmp_path / "run.mcap").read_bytes(), len(mcapfile.MAGIC)
    while offset < len(content):
        offset += 9 + int.from_bytes(content[offset + 1 : offset + 9], "little")
    assert offset == len(content)  # no torn record is left at the end


def _run_long(folder: Path) -> None:
    with RunWriter(folder, PAIR, scenario_text="", seed=0) as writer:
        for i in range(200):
            writer.write(i * 1e-2, TICK)


def _python(script: str, *arguments: object) -> subprocess.CompletedProcess:
    return subprocess.run(
        [sys.executable, "-c", script, *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=120,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
    )
