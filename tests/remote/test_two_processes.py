"""`equipoise plant` and `equipoise control` as two programs: what they log, and who may do what."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from two_programs import compile_kernels, equipoise_command, robot_program, udp_robot

import equipoise
from equipoise.remote.truth import estimate_errors
from equipoise.robots import named_robots

SCENARIO = ["press", "--set", "duration=0.1"]


@pytest.fixture(scope="module")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Have all kernels compiled."""
    compile_kernels(tmp_path_factory.mktemp("compiled"))


@pytest.fixture
def plant(compiled: None, tmp_path: Path) -> Iterator[tuple[subprocess.Popen, str]]:
    """Start a robot on a free port; give its process and the port."""
    with udp_robot(tmp_path, *SCENARIO) as started:
        yield started


def control(port: str, folder: Path, *more: str) -> subprocess.CompletedProcess:
    command = equipoise_command("control", *SCENARIO, "--wire-port", port, *more)
    return subprocess.run(command, capture_output=True, text=True, cwd=folder, check=False)


def test_two_programs_give_the_log_of_one(plant, tmp_path):
    process, port = plant
    looked = control(port, tmp_path)
    assert looked.returncode == 0
    assert "nothing moves without --arm" in looked.stdout
    assert process.poll() is None
    time.sleep(1.1)  # who only looked has left; its place is free after a second
    told = control(port, tmp_path, "--arm", "--no-figures", "--out", "far")
    far = equipoise.load_run(tmp_path / "far")
    near = equipoise.run_scenario(
        "press", overrides=["duration=0.1"], out=tmp_path / "near", figures=False
    )
    assert far.t.size == near.t.size == 100, told.stderr
    for name in ("q", "v", "tau", "q_ref", "lam/press", "lam/left_sole", "mode"):
        # the same bits, unless this process has compiled the kernels itself: then the last differ
        np.testing.assert_allclose(far[name], near[name], rtol=0.0, atol=1e-8, err_msg=name)
    process.wait(timeout=240)
    said = process.stdout.read()
    assert "the commander said so" in said
    assert "It held itself" in said


def test_a_killed_controller_leaves_a_robot_that_holds_itself(plant, tmp_path):
    """In lockstep its time waits meanwhile; then it holds its posture for the rest."""
    from equipoise.remote.drive import RemoteRun
    from equipoise.remote.options import WireOptions
    from equipoise.scenarios import read_scenario

    process, port = plant
    options = WireOptions(port=int(port))
    run = RemoteRun(read_scenario("press", ["duration=0.1"]), options.connect, lockstep=True)
    ticks = run.ticks()
    for _ in range(10):
        next(ticks)
    run.link.datagrams.close()  # as if killed: no farewell gets out
    said, _ = process.communicate(timeout=240)
    assert "nothing was heard for 10." in said
    assert "It held itself" in said
    assert "came down by 0 mm" in said.replace("-0 mm", "0 mm")


def test_unitree_messages_and_estimates_give_the_same_motion(tmp_path):
    """Numbers of 32 bits, no base and no forces on the wire: near, and not bit for bit."""
    pytest.importorskip("cyclonedds")
    if named_robots()["g1"].missing:
        pytest.skip("its files are not installed")
    more = ("--robot", "g1", "--wire", "unitree")
    with robot_program(tmp_path, *SCENARIO, *more, "--wire-port", "73", "--truth", "truth.npz") as (
        process,
        _,
    ):
        told = control("73", tmp_path, *more, "--arm", "--no-figures", "--out", "far")
        process.wait(timeout=240)
    far = equipoise.load_run(tmp_path / "far")
    near = equipoise.run_scenario(
        "press", overrides=["duration=0.1"], robot="g1", out=tmp_path / "near", figures=False
    )
    assert far.t.size == 100, told.stderr
    errors = estimate_errors(far, tmp_path / "truth.npz", 0.02)
    assert errors["base [m]"] < 1e-4
    assert errors["base [rad]"] < 1e-4
    assert errors["press worst"] < 0.5
    with np.load(tmp_path / "truth.npz") as true:
        np.testing.assert_allclose(true["q"][:100], near["q"], atol=1e-4)
