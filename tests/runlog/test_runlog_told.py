"""Every command that reads a log says what is missing of it, and still does what it can."""

from __future__ import annotations

import shutil
import struct
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner

from equipoise import run_scenario
from equipoise.cli import cli

CHUNK, METADATA = 6, 12


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Give the folder of a short run."""
    folder = tmp_path_factory.mktemp("told") / "run"
    run_scenario("press", out=folder, overrides=["duration=0.3"], figures=False)
    return folder


def places(content: bytes, wanted: int) -> list[int]:
    """Return where records of one kind begin."""
    found, at = [], 8
    while at + 9 <= len(content) - 8:
        opcode, length = struct.unpack_from("<BQ", content, at)
        if opcode == wanted:
            found.append(at)
        at += 9 + length
    return found


def cut(content: bytearray) -> bytearray:
    return content[: len(content) * 2 // 3]


def lost_chunk(content: bytearray) -> bytearray:
    content[places(content, CHUNK)[4]] ^= 1
    return content


def spoilt_chunk(content: bytearray) -> bytearray:
    content[places(content, CHUNK)[4] + 80] ^= 1
    return content


def other_label(content: bytearray) -> bytearray:
    return content.replace(b"RLEG_JOINT0", b"RLEG_JOINT9", 1)


DAMAGE = {
    "breaks off": cut,
    "ticks are missing": lost_chunk,
    "had to be left out": spoilt_chunk,
    "does not match its checksum": other_label,
}
COMMANDS: dict[str, Callable[[str, str], list[str]]] = {
    "export": lambda run, to: ["export", run, "--to", f"{to}/run.npz"],
    "plot": lambda run, to: ["plot", run],
    "report": lambda run, to: ["report", run, "--to", f"{to}/report.html"],
    "explain": lambda run, to: ["explain", run, "--at", "0.18"],
}


@pytest.fixture(autouse=True)
def without_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Draw nothing: what is told is looked at here."""
    monkeypatch.setattr("equipoise.analysis.figures.make.make_figures", lambda *given: [])


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("sentence", DAMAGE)
def test_damage_is_told(sentence: str, command: str, run: Path, tmp_path: Path) -> None:
    folder = tmp_path / "damaged"
    shutil.copytree(run, folder)
    log = folder / "run.mcap"
    log.write_bytes(DAMAGE[sentence](bytearray(log.read_bytes())))
    result = CliRunner().invoke(cli, COMMANDS[command](str(folder), str(tmp_path)))
    assert result.exception is None, result.exception
    assert sentence in result.output + (result.stderr or "")
    if command == "report":
        assert sentence in (tmp_path / "report.html").read_text()


@pytest.mark.parametrize("command", COMMANDS)
def test_of_a_whole_log_nothing_is_told(command: str, run: Path, tmp_path: Path) -> None:
    result = CliRunner().invoke(cli, COMMANDS[command](str(run), str(tmp_path)))
    assert result.exit_code == 0
    assert "Note:" not in result.output + (result.stderr or "")
