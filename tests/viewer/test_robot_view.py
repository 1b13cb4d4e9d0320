"""A robot of one's own: sliders move what Pinocchio moves, and bad files are not shown."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from click.testing import CliRunner

pytest.importorskip("viser", reason="needs the extra 'viewer': pip install -e '.[viewer]'")

from scene_poses import in_the_world

from equipoise.cli import cli
from equipoise.errors import InputError, RobotFileError
from equipoise.robots import Robot, robot_urdf_path
from equipoise.robots.files.finding import WARNING, Finding
from equipoise.viewer.robot_view import RobotView, findings_table, limits_table
from equipoise.viewer.server import ViewerServer


def test_sliders_have_the_limits_and_move_the_robot(hrp2: Robot, server: ViewerServer) -> None:
    view = RobotView(hrp2, [], server)
    assert len(view._sliders) == hrp2.na
    for i, slider in enumerate(view._sliders):
        assert (slider.min, slider.max) == (hrp2.q_min[i], hrp2.q_max[i])
    wanted = 0.5 * (hrp2.q_min + hrp2.q_max)
    for slider, value in zip(view._sliders, wanted, strict=True):
        slider.value = value
    assert np.allclose(view.q[7:], wanted)
    data = hrp2.model.createData()
    pin.framesForwardKinematics(hrp2.model, data, view.q)
    for joint in view._drawing._nodes:
        found = in_the_world(view._drawing, joint)
        assert np.allclose(found[:3], data.oMi[joint].translation, atol=2e-4)
    palm = hrp2.frame_id(hrp2.palms[0].frame)
    assert np.allclose(view._frames._nodes[palm].position, data.oMf[palm].translation)
    view.set_joints(hrp2.q_half_sitting[7:])
    assert np.allclose(view.q[7:], hrp2.q_half_sitting[7:])


def test_findings_and_limits_are_text_not_markup(hrp2: Robot) -> None:
    table = findings_table([Finding(WARNING, "link '<b>'", "too light", "Weigh it")])
    assert "<b>" not in table
    assert "too light" in table
    assert "No errors" in findings_table([])
    assert limits_table(hrp2).count("<tr>") == hrp2.na + 1


def test_a_robot_that_cannot_be_trusted_is_not_shown(tmp_path: Path) -> None:
    text = robot_urdf_path("hrp2").read_text(encoding="utf-8")
    bad = tmp_path / "bad.urdf"
    bad.write_text(text.replace('<mass value="', '<mass value="-', 1), encoding="utf-8")
    result = CliRunner().invoke(cli, ["view", "--robot", str(bad), "--no-browser"])
    assert isinstance(result.exception, RobotFileError)
    assert "mass" in str(result.exception)
    missing = CliRunner().invoke(cli, ["view", "--robot", "my.urdf", "--no-browser"])
    assert isinstance(missing.exception, RobotFileError)
    both = CliRunner().invoke(cli, ["view", str(tmp_path), "--robot", "hrp2"])
    assert isinstance(both.exception, InputError)
