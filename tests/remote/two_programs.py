"""Robot and controller as two programs, for tests."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


def equipoise_command(*arguments: str) -> list[str]:
    """Return what starts the command line."""
    return [sys.executable, "-m", "equipoise", *arguments]


def _hear_interrupts() -> None:
    """Hear Ctrl-C, also where the tests themselves run behind a shell that has it ignored."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


@contextmanager
def program(folder: Path, *arguments: str) -> Iterator[subprocess.Popen]:
    """Run the command line beside the test; killed in the end."""
    process = subprocess.Popen(
        equipoise_command(*arguments),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        cwd=folder,
        preexec_fn=_hear_interrupts,
    )
    assert process.stdout is not None
    try:
        yield process
    finally:
        process.kill()
        process.wait()
        process.stdout.close()


@contextmanager
def robot_program(folder: Path, *arguments: str) -> Iterator[tuple[subprocess.Popen, str]]:
    """Start a robot; give its process and what it says of where it is."""
    with program(folder, "plant", *arguments) as process:
        assert process.stdout is not None
        yield process, next(one for one in process.stdout if " stands, " in one)


@contextmanager
def udp_robot(folder: Path, *arguments: str) -> Iterator[tuple[subprocess.Popen, str]]:
    """Start a robot on a free port; give its process and the port."""
    with robot_program(folder, *arguments, "--wire-port", "0") as (process, line):
        yield process, line.split("port ")[1].split(",")[0]


def compile_kernels(folder: Path) -> None:
    """Have all kernels compiled: the run that compiles them may differ in the last digits."""
    command = equipoise_command("run", "press", "--set", "duration=0.01", "--no-figures")
    subprocess.run(command, capture_output=True, cwd=folder, check=False)
