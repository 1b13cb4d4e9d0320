"""The replay without a browser: what is in the scene must be what the log and Pinocchio say."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from click.testing import CliRunner
from viewer_logs import tray_places

pytest.importorskip("viser", reason="needs the extra 'viewer': pip install -e '.[viewer]'")

from scene_poses import in_the_world

from equipoise.cli import cli
from equipoise.errors import EquipoiseError
from equipoise.hqp.row_names import quantity
from equipoise.kinematics import KinematicsEvaluator
from equipoise.tasks.standing import standing_of
from equipoise.viewer.layer import Moment
from equipoise.viewer.layers import centre_of_pressure
from equipoise.viewer.longlog import LongLog
from equipoise.viewer.replay import Replay
from equipoise.viewer.server import ViewerServer


@pytest.fixture
def replay(sway: Path, server: ViewerServer) -> Iterator[Replay]:
    replay = Replay(LongLog(sway), server)
    replay.start()
    yield replay
    replay.stop()


def until(happened: Callable[[], bool]) -> None:
    deadline = time.perf_counter() + 120.0
    while not happened():
        assert time.perf_counter() < deadline, "it did not happen"
        time.sleep(0.01)


def test_the_robot_stands_where_pinocchio_puts_it(replay: Replay) -> None:
    replay.clock.seek(0.25)
    model = tray_places().robot.model
    data = model.createData()
    pin.forwardKinematics(model, data, replay.log.at(0.25).values["q"].copy())
    wanted, robot = pin.SE3ToXYZQUAT(data.oMi[model.njoints - 1]), replay.display._robot
    until(lambda: np.allclose(in_the_world(robot, model.njoints - 1), wanted, atol=2e-4))
    replay.clock.seek(0.0)
    until(lambda: not np.allclose(in_the_world(robot, model.njoints - 1), wanted, atol=2e-4))


def test_keys_and_buttons_move_by_one_tick(replay: Replay) -> None:
    replay.clock.seek(0.5)
    replay.timeline.step(1)
    assert replay.clock.t == replay.log.after(0.5).t
    replay.timeline.step(-1)
    assert replay.clock.t == 0.5
    replay.clock.set_speed(0.1)  # at its end it would stop by itself, and a busy machine is late
    replay.timeline.toggle()
    until(lambda: replay.clock.t > 0.55)
    replay.timeline.toggle()
    assert not replay.clock.playing


def test_the_table_names_every_task_and_judges_it(replay: Replay) -> None:
    """The words are those of `standing_of`; a log without a reference has none."""
    replay.clock.seek(0.1)
    until(lambda: "Level 4" in replay.display._hierarchy._html.content)
    replay.stop()
    display, tick = replay.display, replay.log.at(0.1)
    table = display._hierarchy._html.content
    for level in display.levels:
        for task in level:
            assert task.name in table
    assert '<span class="short">' not in table
    q, v = tick.values["q"], np.zeros(display.setup.robot.nv)
    moment = display.moment(tick.t, {**tick.values, "q_ref": q, "v_ref": v})
    assert moment is not None
    display._hierarchy.show(moment)
    kin = display.setup.robot.at(q, v, tick.t)
    table, last = display._hierarchy._html.content, display.levels[-1]
    assert [task.name for task in last] == ["posture"]
    assert '<span class="left-over">left over</span>' in table.rpartition("Level 4")[2]
    for row in (row for row in table.split("<tr") if "Level" not in row):
        task = next((t for level in display.levels for t in level if f">{t.name}<" in row), None)
        if task is not None:
            stands = standing_of(task, kin, v, tick.t)
            assert f">{stands.word}</span>" in row
            assert all(quantity(*amount) in row for amount in stands.amounts)


def test_plots_and_trails_come_by_themselves(replay: Replay) -> None:
    until(lambda: all(slot._chart is not None for slot in replay.plots.slots))
    t, points = replay.display.trails._path
    assert t[-1] > 0.85
    kin = KinematicsEvaluator(tray_places().robot)
    at = kin.at(replay.log.at(t[7]).values["q"], np.zeros(tray_places().robot.nv))
    palm = tray_places().robot.palms[0].frame
    assert np.allclose(points[7, 0], at.placement(tray_places().robot.frame_id(palm)).translation)


def test_the_centre_of_pressure_is_where_the_force_acts(hrp2) -> None:
    setup = tray_places()
    kin = KinematicsEvaluator(setup.robot).at(setup.robot.q_half_sitting, np.zeros(setup.robot.nv))
    values, points = {}, []
    for k, contact in enumerate(setup.soles.contacts):
        arm = np.array([0.03, -0.02 * k, 0.0])
        force = np.array([5.0, -3.0, 200.0 + 100.0 * k])
        values[f"lam/{contact.name}"] = np.concatenate([force, np.cross(arm, force)])
        points.append(contact.T_world_anchor.act(arm))
    wanted = (200.0 * points[0] + 300.0 * points[1]) / 500.0
    found = centre_of_pressure(setup, Moment(0.0, values, kin))
    assert found is not None
    assert np.allclose(found, wanted)
    assert centre_of_pressure(setup, Moment(0.0, {}, kin)) is None


@pytest.mark.parametrize(
    ("content", "said"), [(b"", "is empty"), (b"\x89PNG", "is not an MCAP file")]
)
def test_foreign_files_get_a_sentence(tmp_path: Path, content: bytes, said: str) -> None:
    (tmp_path / "run.mcap").write_bytes(content)
    result = CliRunner().invoke(cli, ["view", str(tmp_path), "--no-browser"])
    assert isinstance(result.exception, EquipoiseError)
    assert said in str(result.exception)


def test_without_a_run_the_remedy_is_said(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(cli, ["view", "--no-browser"])
    assert isinstance(result.exception, EquipoiseError)
    assert "Run a scenario first" in str(result.exception)
