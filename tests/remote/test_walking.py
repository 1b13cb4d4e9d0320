"""A robot elsewhere walks: as in one process, and it stands before it is let go."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from equipoise.errors import ScenarioError
from equipoise.estimation import EstimatingRobot
from equipoise.remote.drive import RemoteRun
from equipoise.remote.serve import make_robot
from equipoise.scenarios import read_scenario
from equipoise.simulation.operator import StopRequested
from equipoise.simulation.simulation import Simulation

TURNING = "walk.along={count: 2, forward: 0.1, turn: 0.15}"


@cache
def scenario(duration: float):
    return read_scenario("walk", [f"duration={duration}", "physics.engine=rigid", TURNING])


def logged(run) -> dict[str, np.ndarray]:
    """Run; return what was logged of some channels."""
    names = ("q", "q_ref", "tau", "lam/left_sole", "walk/carries", "walk/phase")
    ticks = [[record[name].copy() for name in names] for _, record in run.ticks()]
    return dict(zip(names, map(np.array, zip(*ticks, strict=True)), strict=True))


def test_a_walk_is_that_of_one_process():
    """With turned feet, whose wrenches are told in axes that the robot elsewhere does not know.

    In the ticks of a touchdown one process tells them in the axes of the floor already.
    """
    spec = scenario(2.9)
    run = RemoteRun(spec, lambda *_: make_robot(spec), lockstep=True)
    far, near = logged(run), logged(Simulation(spec))
    for name in ("q", "q_ref", "walk/carries", "walk/phase"):
        np.testing.assert_allclose(far[name], near[name], atol=1e-9, err_msg=name)
    assert set(map(tuple, far["walk/carries"])) == {(1.0, 1.0), (1.0, 0.0), (0.0, 1.0)}
    landed = int(np.argmax(np.diff(far["walk/carries"][:, 0]) > 0.0))
    for name in ("tau", "lam/left_sole"):
        size = np.abs(near[name]).max()
        np.testing.assert_allclose(
            far[name][: landed - 5], near[name][: landed - 5], atol=1e-6 * size
        )
        later = slice(landed + 100, None)  # what was felt at the touchdown has faded
        np.testing.assert_allclose(far[name][later], near[name][later], atol=1e-3 * size)
    assert "touches" in " ".join(run.story)


@pytest.mark.slow
def test_who_ends_a_walk_gets_a_robot_that_stands():
    """Asked for in the middle of a step: the foot comes down beside the other one first."""
    spec = scenario(8.0)
    robot = make_robot(spec)
    run = RemoteRun(spec, lambda *_: robot, lockstep=True)
    last, ended = {}, False
    try:
        for t, record in run.ticks():
            last = {name: record[name].copy() for name in ("v", "walk/carries")}
            if t >= 1.8:
                run.ramp_out.ask("somebody asks")
    except StopRequested:
        ended = True
    assert ended
    assert (last["walk/carries"] == 1.0).all()
    assert np.abs(last["v"]).max() < 0.05
    assert run.walk.walker.stands
    assert robot.t < 6.0
    assert "ramped out: somebody asks" in " ".join(run.story)
    for _ in range(500):
        robot.hold()
    assert np.abs(robot.v).max() < 0.05


def test_a_base_that_is_estimated_cannot_walk():
    spec = scenario(0.1)

    def connect(controls, model):
        setup = controls.setup
        return EstimatingRobot(make_robot(spec), setup.robot, setup.contacts, setup.schedule)

    with pytest.raises(ScenarioError, match="cannot walk yet"):
        RemoteRun(spec, connect, lockstep=True)
