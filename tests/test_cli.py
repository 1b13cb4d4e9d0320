"""The command line as a person meets it: exit codes, messages, files."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

from equipoise import get_robot, load_run

SHORT = ("--set", "duration=0.15", "--no-figures")


def equipoise(*arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "equipoise", *arguments], capture_output=True, text=True, cwd=cwd
    )


@pytest.fixture(scope="module")
def short_run(tmp_path_factory):
    """A run far too short to meet its acceptance."""
    cwd = tmp_path_factory.mktemp("cli")
    equipoise("run", "tray", "--out", "compiles", *SHORT, cwd=cwd)  # see limitations
    return equipoise("run", "tray", "--out", "here", *SHORT, cwd=cwd), cwd / "here"


def test_a_run_that_misses_its_acceptance_exits_with_1(short_run):
    done, folder = short_run
    assert done.returncode == 1, done.stderr
    assert "not met" in done.stdout
    assert "begins at acceptance.after" in done.stdout  # why nothing settled could be judged
    assert "here" in done.stdout
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["passed"] is False
    assert summary["metrics"]["palm_position_error"]["wanted"] == {"max": 0.001}


def test_export_gives_the_promised_arrays(short_run):
    _, folder = short_run
    done = equipoise("export", str(folder), "--format", "npz", cwd=folder)
    assert done.returncode == 0, done.stderr
    robot = get_robot("hrp2")
    with np.load(folder / "run.npz") as arrays:
        n = 150
        assert arrays["t"].shape == (n,)
        for name, width in {
            "q": robot.nq,
            "v": robot.nv,
            "q_ref": robot.nq,
            "v_ref": robot.nv,
            "tau": robot.na,
        }.items():
            assert arrays[name].shape == (n, width)
        for contact in ("left_sole", "right_sole", "grasp"):
            assert arrays[f"lam/{contact}"].shape == (n, 6)
        assert arrays["lam_ref/grasp"].shape == (n, 1)
        run = load_run(folder)
        assert np.array_equal(arrays["q"], run["q"])


def test_a_resolved_scenario_runs_again_to_the_same_bits(short_run, tmp_path):
    _, folder = short_run
    done = equipoise(
        "run", str(folder / "scenario.yaml"), "--out", "b", "--no-figures", cwd=tmp_path
    )
    assert done.returncode == 1, done.stderr
    assert np.array_equal(load_run(tmp_path / "b")["tau"], load_run(folder)["tau"])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("run", "trya"), "tray"),
        (("run", "tray", "--set", "durration=1"), "Did you mean 'duration'"),
        (("run", "tray", "--set", "tasks.look.object=trai"), "tasks.look.object"),
        (("run", "tray", "--set", "tasks.lok.priority=2"), "Did you mean 'look'"),
        (("run", "tray", "--set", "acceptance.limits.speed={max: 1}"), "metric"),
        (("plot", "nowhere"), "nowhere"),
        (("export", "nowhere"), "nowhere"),
        (("robots", "hpr2"), "hrp2"),
        (("check", "nothing.urdf"), "nothing.urdf"),
        (("fly",), "No such command"),
    ],
)
def test_wrong_input_exits_with_2_and_one_message(arguments, message, tmp_path):
    done = equipoise(*arguments, cwd=tmp_path)
    assert done.returncode == 2, done.stdout + done.stderr
    assert message in done.stdout + done.stderr
    assert "Traceback" not in done.stderr


def test_a_place_that_cannot_be_written_is_named(short_run, tmp_path):
    _, folder = short_run
    for command in ("figures", "render"):
        place = "/proc/none" if command == "figures" else "/proc/none/a.mp4"
        done = equipoise(command, str(folder), "--to", place, cwd=tmp_path)
        assert done.returncode == 2, done.stdout + done.stderr
        assert "/proc/none: " in done.stderr
        assert "Traceback" not in done.stderr


def test_a_run_that_has_no_place_to_write_exits_with_2(tmp_path):
    (tmp_path / "taken").write_text("a file, no folder\n")
    done = equipoise("run", "tray", "--out", "taken", *SHORT, cwd=tmp_path)
    assert done.returncode == 2, done.stdout + done.stderr
    assert "taken is no folder" in done.stderr
    assert "Traceback" not in done.stderr
    assert (tmp_path / "taken").read_text() == "a file, no folder\n"


def test_a_video_is_an_mp4_file(short_run, tmp_path):
    _, folder = short_run
    done = equipoise("render", str(folder), "--to", str(folder), cwd=tmp_path)
    assert done.returncode == 2
    assert "ends in .mp4" in done.stderr


def test_render_makes_stills_of_runs_side_by_side(short_run, tmp_path):
    _, folder = short_run
    asked = ["--still", "0.1", "--size", "200x120", "--camera", "hands", "--to", "two.png"]
    done = equipoise("render", str(folder), str(folder), *asked, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert imread(tmp_path / "two.png").shape[:2] == (120, 400)
    for option, value, told in (
        ("--camera", "sid", "Did you mean 'side'"),
        ("--size", "big", "WIDTHxHEIGHT"),
        ("--speed", "0", "0.01 to 100"),
    ):
        done = equipoise("render", str(folder), option, value, cwd=tmp_path)
        assert done.returncode == 2, done.stdout
        assert told in done.stderr


def test_a_film_without_ffmpeg_says_what_to_install(short_run, tmp_path):
    _, folder = short_run
    (tmp_path / "imageio_ffmpeg.py").write_text("raise ImportError('there is none')\n")
    script = "from equipoise.cli import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", script, "render", str(folder), "--to", "here.mp4"],
        capture_output=True,
        text=True,
        cwd=tmp_path,
    )
    assert done.returncode == 2, done.stderr
    assert "pip install 'equipoise[film]'" in done.stderr


def test_check_passes_the_shipped_robot_and_refuses_a_broken_one(tmp_path):
    path = equipoise("robots", "hrp2", "--path", cwd=tmp_path).stdout.strip()
    assert equipoise("check", path, cwd=tmp_path).returncode == 0
    broken = tmp_path / "broken.urdf"
    broken.write_text(Path(path).read_text().replace('value="15.02949"', 'value="nan"'))
    done = equipoise("check", str(broken), cwd=tmp_path)
    assert done.returncode == 2
    assert "BODY" in done.stdout


def test_lists_name_what_there_is(tmp_path):
    assert "hrp2" in equipoise("robots", cwd=tmp_path).stdout
    assert "tray" in equipoise("scenarios", cwd=tmp_path).stdout
    robot = equipoise("robots", "hrp2", cwd=tmp_path).stdout
    assert "LARM_JOINT3" in robot
    assert "left_palm_skin" in robot
    assert "speed [rad/s]" in robot
    assert "duration: 6.2" in equipoise("scenarios", "tray", cwd=tmp_path).stdout


def test_an_existing_run_is_not_overwritten(short_run, tmp_path):
    _, folder = short_run
    before = (folder / "run.mcap").read_bytes()
    done = equipoise("run", "tray", "--out", str(folder), *SHORT, cwd=tmp_path)
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert (folder / "run.mcap").read_bytes() == before


def test_the_table_is_printed_before_the_figures_are_drawn(tmp_path):
    done = equipoise("run", "tray", "--out", "here", "--set", "duration=0.05", cwd=tmp_path)
    assert done.returncode == 1, done.stderr
    places = [done.stdout.index(text) for text in ("measuring", "Result:", "drawing", "Figures:")]
    assert places == sorted(places)
    assert len(list((tmp_path / "here" / "figures").glob("*.png"))) == 6


def test_ctrl_c_leaves_a_readable_log(tmp_path):
    process = subprocess.Popen(
        [
            *(sys.executable, "-m", "equipoise", "run", "tray", "--out", "cut", "--no-figures"),
            *("--set", "duration=600"),  # it never ends by itself before it is interrupted
        ],
        cwd=tmp_path,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        preexec_fn=partial(signal.signal, signal.SIGINT, signal.SIG_DFL),  # a shell may ignore it
    )
    log = tmp_path / "cut" / "run.mcap"
    deadline = time.monotonic() + 600  # kernels that are not compiled yet take their minutes
    while time.monotonic() < deadline and not (log.exists() and log.stat().st_size > 300_000):
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=120) == 130
    run = load_run(tmp_path / "cut")
    assert len(run.t) > 50
    assert run.complete
    assert run.summary["ended"] == "interrupted"
