"""A foot of a walk that loses its ground: the other carries and it is put down again, or SAFE."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from equipoise.control.modes import Mode
from equipoise.errors import ScenarioError
from equipoise.robots import get_robot
from equipoise.scenarios import read_scenario
from equipoise.simulation.lost_feet import LostFeet
from equipoise.simulation.sensors import Reading
from equipoise.simulation.simulation import Simulation
from equipoise.studies.in_memory import run_in_memory
from equipoise.walking import LEFT, RIGHT, Feet, WalkClock, WalkPlanner, WalkSettings
from equipoise.wbc import WholeBodyController

PLANK = (
    "world.bodies={plank: {at: {xyz: [0.18, -0.095, 0.01]}, shapes: [{box: [0.4, 0.17, 0.02]}]}}"
)
VANISHES = "faults.vanishing=[{body: plank, at: 4.1}]"


def pulled(force, start):
    """Pull the right foot upwards for 0.3 s."""
    sole = get_robot("hrp2").soles[1].frame
    push = f"{{frame: {sole}, force: [0, 0, {force}], start: {start}, duration: 0.3}}"
    return [f"faults.pushes=[{push}]"]


def run(engine, overrides, duration, *, stop=True):
    if engine == "mujoco":
        pytest.importorskip("mujoco")
    given = [f"physics.engine={engine}", f"duration={duration}", *overrides]
    return run_in_memory(Simulation(read_scenario("slow_steps", given)), stop_when_off=stop)


def times(ticks, words):
    return [float(one.split()[2]) for one in ticks.simulation.story if words in one]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("engine", "fault", "lost"),
    [
        ("rigid", [PLANK, VANISHES], 4.1),
        ("mujoco", [PLANK, VANISHES], 4.1),
        ("mujoco", pulled(100, 4.25), 4.25),
    ],
)
def test_a_foot_that_lost_its_ground_is_put_down_again_and_the_walk_goes_on(engine, fault, lost):
    """A plank vanishes, or the foot is pulled off; the centre of mass is over the other one yet."""
    ticks = run(engine, fault, 6.7)
    assert ticks.ended == "completed"
    [told] = times(ticks, "the right foot has lost its ground")
    assert lost < told < lost + 0.12
    touched = [t for t in times(ticks, "the right foot touches") if t > told]
    assert len(touched) == 1
    found = ticks.run
    carries, alone = found["walk/carries"], (found.t > told) & (found.t < touched[0])
    assert (carries[alone] == [1.0, 0.0]).all()
    assert (carries[-1] == 1.0).all()
    late = found.t > touched[0] + 0.2
    assert np.abs(found["dq"][late, :3]).max() < 0.005
    assert np.abs(found["dq"][late, 6:]).max() < 0.02
    # the foot came down several times; it is one step
    assert (np.diff(carries[:, 1]) > 0.0).sum() > 1
    assert ticks.metrics(["walk_steps"]) == {"walk_steps": 1.0}


@pytest.mark.slow
def test_where_the_other_foot_cannot_carry_it_is_made_safe():
    """The centre of mass is half-way between the feet when a plank vanishes under one."""
    ticks = run("mujoco", [PLANK, "faults.vanishing=[{body: plank, at: 5.0}]"], 5.5)
    assert ticks.ended == "off"
    assert not times(ticks, "is put down again")


def test_a_foot_that_does_not_come_back_is_told_when_nothing_else_holds(hrp2):
    """Between the feet one sole is not enough; over the left one it is."""
    feet = Feet.of(hrp2)
    kin = hrp2.at(hrp2.q_half_sitting)
    stance = tuple(kin.placement(sole.frame) for sole in feet.soles)
    asked = []
    settings = WalkSettings(float(kin.p_world_com[2]))
    planner = WalkPlanner(feet, settings)
    aside = stance[LEFT].translation[1]
    for shift, held in ((0.0, False), (aside, True)):
        walker = SimpleNamespace(
            planner=planner, stance=stance, supports=(LEFT, RIGHT), clock=WalkClock(),
            plan=planner.begin(stance, []), lose=lambda t, foot: asked.append((t, foot)),
            lifts_soon=lambda foot: False,
        )  # fmt: skip
        lost = LostFeet(walker, hrp2, ("left", "right"))
        q = hrp2.q_half_sitting.copy()
        q[1] += shift
        reading = Reading(q, np.zeros(hrp2.nv), np.zeros(12))
        told = [lost.update(1e-3 * k, ("right",), reading) for k in range(200)]
        assert not any(told[:150])
        assert (told[-1] == "") is held
    assert asked == [(0.012, RIGHT)] * 2


def test_a_law_that_is_given_up_holds_and_does_not_come_back(hrp2):
    controller = WholeBodyController.standing(hrp2)
    q, v = hrp2.q_half_sitting, np.zeros(hrp2.nv)
    lam = np.tile([0.0, 0.0, 0.5 * 9.81 * hrp2.mass, 0.0, 0.0, 0.0], 2)
    for k in range(50):
        controller.step(k * controller.dt, q, v, lam)
    supervisor = controller.supervisor
    supervisor.give_up(50 * controller.dt, "the right foot has lost its ground")
    assert supervisor.mode is Mode.SAFE
    for k in range(50, 60):
        assert np.isfinite(controller.step(k * controller.dt, q, v, lam).tau).all()
    assert supervisor.mode is Mode.SAFE
    supervisor.give_up(1.0, "again")
    assert [change.cause for change in supervisor.changes] == ["the right foot has lost its ground"]


def test_what_cannot_vanish_is_refused():
    with pytest.raises(ScenarioError, match=r"faults\.vanishing\.0\.body"):
        Simulation(read_scenario("slow_steps", ["faults.vanishing=[{body: plank, at: 1}]"]))
    rigid = ["physics.engine=rigid", "physics.contacts=bilateral", PLANK, VANISHES]
    with pytest.raises(ScenarioError):
        Simulation(read_scenario("tray", rigid))
