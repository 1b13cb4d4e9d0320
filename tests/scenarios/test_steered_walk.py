"""A walk that is steered, with a body: forwards, round a bend, sideways, and a stop, in MuJoCo."""

from __future__ import annotations

import numpy as np
import pytest

from equipoise.errors import ScenarioError
from equipoise.scenarios import read_scenario
from equipoise.simulation.simulation import Simulation
from equipoise.studies.in_memory import run_in_memory
from equipoise.walking.feet import yaw_of

# one entry a step: from 0.6 of the way through a swing to the middle of a double support
STEER = (
    "walk.steer=[{at: 0.1, forward: 0.12}, {at: 2.5, forward: 0.06, turn: 0.1}, "
    "{at: 3.85, left: -0.02}, {at: 5.3}]"
)
SHORT = ["walk.timing={single: 0.6, double: 0.3}", "duration=7.0", STEER]


@pytest.mark.slow
@pytest.mark.parametrize("robot", ["hrp2", "talos", "g1"])
def test_it_walks_as_it_is_steered(robot):
    pytest.importorskip("mujoco")
    scenario = read_scenario("steered_walk", SHORT, robot=robot)
    ticks = run_in_memory(Simulation(scenario), stop_when_off=True)
    assert ticks.ended == "completed", ticks.simulation.story
    found = ticks.metrics(["base_error", "posture_error", "switch_jump"])
    assert found["base_error"] < 2e-3
    assert found["posture_error"] < (0.06 if robot == "g1" else 0.025)
    assert found["switch_jump"] < 1e-3
    run, walker = ticks.run, ticks.simulation.walk.walker
    # the place between the feet went by the velocities of its steps, along its heading
    period = walker.planner.period
    lifts = [one.t for one in walker.events if one.kind == "lift"]
    x, heading = np.zeros(2), 0.0
    for t in lifts[:-1]:  # the last one closes; how fast a step goes is known when its foot lifts
        forward, left, turn = run["walk/goes"][round(t / scenario.control.period) - 1]
        heading += 0.5 * period * turn
        c, s = np.cos(heading), np.sin(heading)
        x += period * np.array([c * forward - s * left, s * forward + c * left])
        heading += 0.5 * period * turn
    middle = walker.planner.feet.middle(walker.stance)
    start = walker.planner.feet.middle(ticks.simulation.assembly.walk.plan.stance)
    stride = np.abs(run["walk/goes"][:, :2]).max() * period
    assert np.linalg.norm(middle.translation[:2] - start.translation[:2] - x) < stride
    assert abs(yaw_of(middle) - heading) < np.abs(run["walk/goes"][:, 2]).max() * period
    assert walker.swinging is None
    assert not walker.remaining
    assert walker.supports == (0, 1)
    assert run["walk/stick"][-1].tolist() == [0.0, 0.0, 0.0]
    assert len(lifts) >= 5


def test_what_a_stick_says_is_checked():
    for change, words in (
        ("walk.steer=[{at: 1.0}, {at: 1.0, turn: 0.1}]", "comes after the one before"),
        ("walk.steer=[{at: 1.0, forwards: 0.1}]", "forward"),
        ("walk={steer: [], along: {count: 2}}", "exactly one of"),
    ):
        with pytest.raises(ScenarioError, match=words):
            read_scenario("steered_walk", [change])
    walk = read_scenario("steered_walk", robot="talos").walk
    factor = walk.stride.forward / 0.2
    assert factor > 1.0  # TALOS is larger
    assert walk.steer[0].forward == pytest.approx(0.15 * factor, rel=1e-4)
    assert walk.steer[1].turn == 0.08
