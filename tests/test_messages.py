"""What a person reads who made a slip: whose value it is, in which file and line, what to do."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from equipoise import run_scenario
from equipoise.cli import WRONG_INPUT, cli, main
from equipoise.errors import EquipoiseError, InputError
from equipoise.scenarios import read_scenario

MINE = """extends: press
name: mine
tasks:
  right_hand:
    frame: right_plam
"""


def said(*arguments: str) -> str:
    """Return the sentence with which a command refuses."""
    result: Result = CliRunner().invoke(cli, arguments)
    if isinstance(result.exception, EquipoiseError):
        return str(result.exception)
    return result.output


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("control.gains.alpha=-1", "greater than 0"),
        ("durration=1", "unknown key"),
        ("tasks.look.object=trai", "There is no object"),
        ("contacts.grasp.regulated.fz.values.1=-4", "can only push"),
        ("acceptance.limits.speed={max: 1}", "There is no metric"),
        ("tasks.com.rate=fast", "valid number"),
    ],
)
def test_an_override_is_named_and_no_line_of_a_file(override: str, words: str) -> None:
    told = said("run", "tray", "--set", "duration=1", "--set", override)
    assert told.startswith(f"--set {override}: ")
    assert words in told
    assert "line " not in told


def test_a_file_is_named_with_its_line(tmp_path: Path) -> None:
    mine = tmp_path / "mine.yaml"
    mine.write_text(MINE)
    assert f"{mine}: line 5, tasks.right_hand.frame: There is no frame" in said("run", str(mine))
    mine.write_text(MINE.replace("frame: right_plam", "priority: 99"))
    assert f"{mine}: line 5, tasks.right_hand.priority: " in said("run", str(mine))
    mine.write_text(MINE.replace("right_plam", "right_palm"))
    told = said("run", str(mine), "--set", "tasks.right_hand.frame=left_plam")
    assert told.startswith("--set tasks.right_hand.frame=left_plam: ")


def test_a_key_called_like_the_kind_is_told_as_it_stands() -> None:
    with pytest.raises(InputError, match=r": contacts\.press\.force: this contact"):
        read_scenario("press", ["contacts.press.force.values.0=-1"])
    with pytest.raises(InputError, match=r": contacts\.press\.surface: give exactly one"):
        read_scenario("press", ["contacts.press.surface.sphere=0.1"])


def test_what_is_no_scenario_gets_a_sentence(tmp_path: Path) -> None:
    binary = tmp_path / "binary.yaml"
    binary.write_bytes(bytes(range(256)))
    zeros = tmp_path / "zeros.yaml"
    zeros.write_bytes(bytes(100))
    folder = tmp_path / "folder.yaml"
    folder.mkdir()
    assert f"there is no file {tmp_path / 'no.yaml'}" in said("run", str(tmp_path / "no.yaml"))
    for path in (binary, zeros):
        assert f"{path} is no text, hence no scenario" in said("run", str(path))
    assert f"{folder} cannot be read: is a directory" in said("run", str(folder))
    for path in (binary, folder):
        assert "Errno" not in said("run", str(path))


@pytest.mark.parametrize("what", ["run", "file", "below a file", "forbidden"])
def test_a_place_that_cannot_be_written_is_refused_before_work(what: str, tmp_path: Path) -> None:
    place = tmp_path / "place"
    if what == "run":
        place.mkdir()
        (place / "run.mcap").touch()
    elif what == "forbidden":
        if not Path("/proc").is_dir():
            pytest.skip("no /proc here")
        place = Path("/proc/place")
    else:
        place.touch()
        place = place / "run" if what == "below a file" else place
    stages: list[str] = []
    with pytest.raises(InputError):
        run_scenario("tray", out=place, report=lambda stage, share: stages.append(stage))
    assert stages == []


def test_a_place_that_is_looked_at_is_left_as_it_was(tmp_path: Path) -> None:
    with pytest.raises(InputError):
        run_scenario("tray", out=tmp_path / "a" / "b", overrides=["tasks.look.object=trai"])
    assert list(tmp_path.iterdir()) == []


def test_plot_does_not_list_a_folder(tmp_path: Path) -> None:
    (tmp_path / "secret.txt").touch()
    told = said("plot", str(tmp_path))
    assert "There is no run.mcap" in told
    assert "secret" not in told
    (tmp_path / "press-1").mkdir()
    (tmp_path / "press-1" / "run.mcap").touch()
    assert "it holds press-1" in said("plot", str(tmp_path))


def test_the_help_of_run_explains_set() -> None:
    told = CliRunner().invoke(cli, ["run", "--help"]).output
    assert told.count("--set") >= 6
    assert "--set duration=3" in told.split("mass_scale=1.3")[1].splitlines()[0]  # several
    assert "waypoints.4.xyz=[0.52,0,0.86]" in told  # an item of a list
    assert "'title=A tray, heavier'" in told  # spaces


def test_every_set_in_the_help_is_right() -> None:
    told = CliRunner().invoke(cli, ["run", "--help"]).output
    read_scenario("tray", ["disturbances.mass_scale=1.3", "duration=3", "title=A tray, heavier"])
    read_scenario("tray", ["world.objects.tray.waypoints.4.xyz=[0.52,0,0.86]"])
    read_scenario("tray", ["disturbances.payloads=[{mass: 2.0, object: tray}]"])
    assert "'disturbances.payloads=[{mass: 2.0, object: tray}]'" in told


def test_check_marks_and_counts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "arm"
    folder.mkdir()
    (folder / "arm.yaml").write_text("urdf: {package: no_such_package_here, file: x.urdf}\n")
    monkeypatch.chdir(folder)
    for place in (".", str(folder)):
        result = CliRunner().invoke(cli, ["check", place])
        assert result.exit_code == WRONG_INPUT
        lines = result.output.splitlines()
        assert lines[-1] == "arm: 1 error, 0 warnings"
        assert lines[0].startswith("error: ")
        assert "pip install no_such_package_here" in lines[0]
        assert "SourceEntry" not in result.output


def test_check_counts_what_it_marks() -> None:
    from equipoise.robots import robot_urdf_path

    result = CliRunner().invoke(cli, ["check", str(robot_urdf_path("hrp2"))])
    marked = [line.partition(":")[0] for line in result.output.splitlines()[:-1]]
    errors, warnings = marked.count("error"), marked.count("warning")
    assert len(marked) == errors + warnings
    last = result.output.splitlines()[-1]
    assert f"{errors} error{'s' * (errors != 1)}, {warnings} warning{'s' * (warnings != 1)}" in last


def test_a_refusal_is_quick(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing is built for a place that cannot be written."""
    place = tmp_path / "place"
    place.touch()
    began = time.process_time()
    monkeypatch.setattr("sys.argv", ["equipoise", "run", "tray", "--out", os.fspath(place)])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == WRONG_INPUT
    assert "is no folder" in capsys.readouterr().err
    assert time.process_time() - began < 10.0
