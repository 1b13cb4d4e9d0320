"""Damaged logs of a real run: what every reader makes of each, and whether it says so.

`python benchmarks/fuzz_logs.py --count 300 [--seed 0] [--commands]`

A log of half a second is damaged in one way: cut off, bits flipped, a block zeroed, overwritten,
taken out, repeated, or noise put in; a record's opcode or length changed; the head, the end, the
texts, one chunk or its index hit. It is then read whole, in a window and piece by piece as the
viewer does; with `--commands` also by `export`, `explain` and `report`.

`refused`: a sentence says that nothing can be read. `told`: what is left is read, and a sentence
says that it is not all. `whole`: every number, label and text is as it was written. Anything else
fails: a traceback, a number or a label that was never written, ticks that are lost without a word
(`silent`), more than 20 s. Ends with 1 if one failed.
"""

from __future__ import annotations

import argparse
import struct
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout, suppress
from io import StringIO
from pathlib import Path

import numpy as np

from equipoise import run_scenario
from equipoise.errors import EquipoiseError
from equipoise.runlog import Run, check_log, load_run

SLOW = 20.0  # [s] of processor time after which a reader counts as hanging
CHUNK, INDEX, METADATA = 6, 7, 12  # opcodes
FAILURES = ("traceback", "wrong", "silent", "hang")

Damage = Callable[[np.random.Generator, bytearray], bytearray]


def records_of(content: bytes) -> list[tuple[int, int, int]]:
    """Return opcode, place [bytes] and length of each record."""
    found, at = [], 8
    while at + 9 <= len(content) - 8:
        opcode, length = struct.unpack_from("<BQ", content, at)
        found.append((opcode, at, length))
        at += 9 + length
    return found


def cut(rng: np.random.Generator, content: bytearray) -> bytearray:
    """Cut off the end."""
    return content[: int(rng.integers(0, len(content)))]


def flip(rng: np.random.Generator, content: bytearray) -> bytearray:
    """Flip one to eight bits anywhere."""
    for place in rng.integers(0, len(content), size=int(rng.integers(1, 9))):
        content[place] ^= 1 << int(rng.integers(0, 8))
    return content


def block(rng: np.random.Generator, content: bytearray) -> bytearray:
    """Zero, overwrite, take out, repeat or put in a block."""
    start, size = int(rng.integers(0, len(content))), int(rng.integers(1, 5000))
    end = min(start + size, len(content))
    noise = rng.bytes(end - start)
    return rng.choice(
        np.array([zeroed, overwritten, taken, repeated, put_in], dtype=object)
    )(content, start, end, noise)  # fmt: skip


def zeroed(content: bytearray, start: int, end: int, noise: bytes) -> bytearray:
    """Write zeros, as a disk does whose blocks were never written."""
    content[start:end] = bytes(end - start)
    return content


def overwritten(content: bytearray, start: int, end: int, noise: bytes) -> bytearray:
    """Write noise."""
    content[start:end] = noise
    return content


def taken(content: bytearray, start: int, end: int, noise: bytes) -> bytearray:
    """Take the block out."""
    return content[:start] + content[end:]


def repeated(content: bytearray, start: int, end: int, noise: bytes) -> bytearray:
    """Write the block twice."""
    return content[:end] + content[start:]


def put_in(content: bytearray, start: int, end: int, noise: bytes) -> bytearray:
    """Put noise in."""
    return content[:start] + bytearray(noise) + content[start:]


def record(rng: np.random.Generator, content: bytearray) -> bytearray:
    """Hit one record: its opcode, its length, its body; take it out, or write it twice."""
    opcode = int(rng.choice([CHUNK, INDEX, METADATA, 0]))
    chosen = [r for r in records_of(bytes(content)) if opcode in (0, r[0])]
    _, at, length = chosen[int(rng.integers(0, len(chosen)))]
    what = int(rng.integers(0, 5))
    if what == 0:
        content[at] ^= 1 << int(rng.integers(0, 8))
    elif what == 1:
        content[at + 1 + int(rng.integers(0, 8))] ^= 1 << int(rng.integers(0, 8))
    elif what == 2 and length:
        content[at + 9 + int(rng.integers(0, length))] ^= 1 << int(rng.integers(0, 8))
    elif what == 3:
        return content[:at] + content[at + 9 + length :]
    else:
        return content[: at + 9 + length] + content[at:]
    return content


DAMAGES: tuple[Damage, ...] = (cut, flip, block, record, record)


def judge(path: Path, log: Run) -> str:
    """Return what became of a damaged log in the hands of all readers."""
    try:
        run = load_run(path)
    except EquipoiseError as error:
        return "refused" if str(error) else "silent"
    told = bool(run.note) and not run.complete
    if not told and check_log(path):
        return "silent"
    same = (
        dict(run.channels) == dict(log.channels)
        and (run.scenario_text, run.seed) == (log.scenario_text, log.seed)
        and dict(run.info) == dict(log.info)
    )
    if not same:
        return "told" if told else "wrong"
    where = np.searchsorted(log.t, run.t)
    if (where >= log.t.size).any() or not np.array_equal(run.t, log.t[where]):
        return "wrong"
    if not all(np.array_equal(run[name], log[name][where]) for name in log):
        return "wrong"
    if run.t.size < log.t.size:
        outcome = "told" if told else "silent"
    else:
        outcome = "told" if told else "whole"
    return outcome if windows_tell(path, log) else "silent"


def windows_tell(path: Path, log: Run) -> bool:
    """Return whether windows hold what they should, or say that they do not."""
    for start, stop in ((0.1, 0.2), (0.25, 0.26), (0.45, 1.0)):
        try:
            run = load_run(path, start=start, stop=stop)
        except EquipoiseError:
            continue
        wanted = log.t[(log.t >= start) & (log.t < stop)]
        if not np.array_equal(run.t, wanted) and (run.complete or not run.note):
            return False
    return True


def view(path: Path) -> None:
    """Read a log as the viewer does: single ticks, then piece by piece."""
    from equipoise.viewer.longlog import LongLog

    long = LongLog(path)
    for t in (0.0, 0.123, 0.4, 9.0):
        long.at(t)
        long.after(t)
        long.before(t)
    for _ in long.pieces((7, 1)):
        pass


def run_commands(path: Path) -> str:
    """Return "" or what failed when the commands read a log."""
    from click.testing import CliRunner

    from equipoise.cli import cli

    to = str(path.parent)
    for arguments in (
        ["export", str(path), "--to", f"{to}/run.npz"],
        ["explain", str(path), "--at", "0.3"],
        ["report", str(path), "--to", f"{to}/report.html"],
    ):
        result = CliRunner().invoke(cli, arguments)
        if result.exception is not None and not isinstance(
            result.exception, SystemExit | EquipoiseError
        ):
            return "traceback"
        whole = not check_quietly(path)
        said = isinstance(result.exception, EquipoiseError) or "Note:" in result.output
        if not whole and not said:
            return "silent"
    return ""


def check_quietly(path: Path) -> str:
    """Return what is wrong with a log in a sentence, "" for nothing."""
    try:
        return check_log(path)
    except EquipoiseError as error:
        return str(error)


def examine(path: Path, log: Run, *, commands: bool) -> str:
    """Return the outcome of one damaged log."""
    began = time.process_time()
    try:
        outcome = judge(path, log)
        if outcome != "refused":
            with suppress(EquipoiseError):
                view(path)
        if commands and outcome not in FAILURES:
            outcome = run_commands(path) or outcome
    except Exception:
        traceback.print_exc()
        return "traceback"
    return "hang" if time.process_time() - began > SLOW else outcome


def fuzz(count: int, seed: int, folder: Path, *, commands: bool = False) -> Counter[str]:
    """Damage one log `count` times; return how often each outcome came."""
    made = folder / "whole"
    if not made.exists():
        with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
            run_scenario("press", out=made, overrides=["duration=0.5"], figures=False)
    log = load_run(made)
    content = (made / "run.mcap").read_bytes()
    outcomes: Counter[str] = Counter()
    place = folder / "damaged" / "run.mcap"
    place.parent.mkdir(exist_ok=True)
    for k in range(count):
        rng = np.random.default_rng([seed, k])
        damage = DAMAGES[int(rng.integers(0, len(DAMAGES)))]
        place.write_bytes(damage(rng, bytearray(content)))
        outcome = examine(place, log, commands=commands)
        outcomes[outcome] += 1
        if outcome in FAILURES:
            print(f"  seed {seed} number {k} ({damage.__name__}): {outcome}", flush=True)
    return outcomes


def main() -> int:
    """Run the fuzzer."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--commands", action="store_true", help="also let the commands read them")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        outcomes = fuzz(given.count, given.seed, Path(folder), commands=given.commands)
    print(f"{given.count} damaged logs: {dict(outcomes)}")
    return 1 if any(outcomes[name] for name in FAILURES) else 0


if __name__ == "__main__":
    sys.exit(main())
