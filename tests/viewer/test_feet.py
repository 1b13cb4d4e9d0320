"""The soles of a walk in the colours of their phases; nothing of a robot that stands."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("viser", reason="needs the extra 'viewer': pip install -e '.[viewer]'")

from equipoise.contacts import Phase
from equipoise.scenarios import read_scenario
from equipoise.simulation.build.setup import build_setup
from equipoise.viewer.feet import COLOURS, LIFT, FeetLayer
from equipoise.viewer.layer import Moment


def layer_of(scenario: str):
    lines = SimpleNamespace(points=None, colors=None, visible=True)
    scene = SimpleNamespace(add_line_segments=lambda *args, **more: lines)
    setup = build_setup(read_scenario(scenario))
    return FeetLayer(scene, setup), lines, setup.robot


def test_each_sole_is_outlined_where_it_is_in_the_colour_of_its_phase() -> None:
    layer, lines, robot = layer_of("walk")
    kin = robot.at(robot.q_half_sitting)
    codes = np.array([Phase.HELD.code, Phase.LOST.code])
    layer.show(Moment(0.0, {"walk/phase": codes}, kin))
    assert lines.points.shape == (8, 2, 3)
    for k, (sole, phase) in enumerate(zip(robot.soles, (Phase.HELD, Phase.LOST), strict=True)):
        edges = lines.points[4 * k : 4 * k + 4]
        assert (lines.colors[4 * k : 4 * k + 4] == COLOURS[phase]).all()
        T = kin.placement(sole.frame)
        own = np.array([T.actInv(point.astype(float)) for point in edges[:, 0]])
        assert np.allclose(own.min(axis=0)[:2], [sole.x_min, sole.y_min], atol=1e-6)
        assert np.allclose(own.max(axis=0)[:2], [sole.x_max, sole.y_max], atol=1e-6)
        assert np.allclose(edges[:, 1], np.roll(edges[:, 0], -1, axis=0))  # it closes
        assert np.allclose(own[:, 2], LIFT, atol=1e-6)


def test_an_old_log_and_a_robot_that_stands_have_none() -> None:
    layer, lines, robot = layer_of("walk")
    layer.show(Moment(0.0, {}, robot.at(robot.q_half_sitting)))
    assert lines.points is None
    layer, lines, robot = layer_of("press")
    layer.show(Moment(0.0, {"walk/phase": np.zeros(2)}, robot.at(robot.q_half_sitting)))
    assert lines.points is None
    layer.set_visible(False)
    assert not lines.visible
