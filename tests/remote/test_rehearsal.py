"""Controller and robot over a virtual wire: the same bits in lockstep, a safe end in real time."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from equipoise.errors import ScenarioError
from equipoise.remote.drive import NO_PUSH, RemoteRun
from equipoise.remote.rehearsal import Rehearsed, rehearse
from equipoise.scenarios import read_scenario
from equipoise.simulation.build.assemble import Prepared, assemble_plant, starting_posture
from equipoise.simulation.build.setup import build_setup
from equipoise.simulation.operator import OperatorRequest
from equipoise.simulation.simulated_robot import SimulatedRobot
from equipoise.simulation.simulation import Simulation
from equipoise.wire import CommandMode, RobotCommand, RobotLostError, RobotMode
from equipoise.wire.virtual import NetworkFaults

BAD = NetworkFaults(0.3, 0.2, 0.1, 0.2, (0.0, 0.005))
UNKIND = (
    "faults={measurement_delay: 0.002, command_delay: 0.001, missed_ticks: 0.2, "
    "pushes: [{frame: right_palm, force: [5.0, 0.0, 0.0], start: 0.01, duration: 0.02}]}",
    "sensors={joint_position: {noise: 1.0e-5}, force: {noise: 0.1, delay: 0.001}}",
)


def press(duration: float, *changes: str):
    return read_scenario("press", [f"duration={duration}", *changes])


@cache
def prepared() -> Prepared:
    scenario = press(0.1)
    setup = build_setup(scenario)
    return Prepared(setup.robot, starting_posture(scenario, setup))


@pytest.mark.parametrize("changes", [(), UNKIND], ids=["plain", "faults"])
def test_lockstep_over_a_bad_network_gives_the_bits_of_one_process(changes):
    """Every command is that of the simulation in one process, sensor errors and faults included."""
    scenario, seen = press(0.06, *changes), []
    tried = Rehearsed(BAD, 1)
    outcome = rehearse(
        scenario,
        prepared(),
        tried,
        lockstep=True,
        see=lambda t, record: seen.append((t, record["tau"].copy())),
    )
    near = Simulation(scenario, prepared())
    wanted = [(t, record["tau"].copy()) for t, record in near.ticks()]
    assert outcome.ended == "completed"
    assert [t for t, _ in seen] == [t for t, _ in wanted]
    np.testing.assert_array_equal([tau for _, tau in seen], [tau for _, tau in wanted])


def test_the_log_is_that_of_one_process_where_sensors_do_not_err():
    scenario, seen = press(0.05), []
    rehearse(
        scenario,
        prepared(),
        Rehearsed(NetworkFaults(), 1),
        lockstep=True,
        see=lambda t, record: seen.append({n: v.copy() for n, v in record.views.items()}),
    )
    near = Simulation(scenario, prepared())
    names = {channel.name for channel in near.channels} - {"violation"}
    for values, (_, record) in zip(seen, near.ticks(), strict=True):
        for name in names:
            np.testing.assert_array_equal(values[name], record[name], err_msg=name)
        assert values["violation"][0] < 1e-6


@pytest.mark.parametrize("killed", ["", "loop", "robot"])
def test_a_bad_network_and_a_kill_end_safely(killed):
    tried = Rehearsed(BAD, 2, killed, 0.05)
    outcome = rehearse(press(0.12), prepared(), tried, lockstep=False)
    assert not outcome.fell
    assert outcome.share <= 1.0
    assert outcome.fastest < 0.3


@pytest.mark.parametrize(("length", "runs_on"), [(0.01, True), (0.06, False)])
def test_a_short_silence_is_survived_and_a_long_one_ends_standing(length, runs_on):
    faults = NetworkFaults(silences=((0.03, 0.03 + length),))
    outcome = rehearse(press(0.12), prepared(), Rehearsed(faults, 3), lockstep=False)
    assert (outcome.ended == "completed") is runs_on
    assert not outcome.fell
    if not runs_on:
        assert "holds itself" in outcome.ended


def test_a_session_is_the_same_twice():
    both = [rehearse(press(0.05), prepared(), Rehearsed(BAD, 5), lockstep=False) for _ in "ab"]
    assert both[0] == both[1]


def test_what_nothing_measures_is_not_driven():
    with pytest.raises(ScenarioError, match="nothing measures how far a pushed object has gone"):
        RemoteRun(read_scenario("telephone"), lambda controls, model: None, lockstep=True)


def near_run(*changes: str) -> RemoteRun:
    """Return a run whose robot is in this process, behind the same interface."""
    scenario = press(0.05, *changes)

    def connect(controls, model):
        plant, tau = assemble_plant(scenario, controls.setup, controls.q_start)
        return SimulatedRobot(plant, scenario.control.period, tau)

    return RemoteRun(scenario, connect, lockstep=True, prepared=prepared())


@pytest.mark.parametrize("changes", [(), UNKIND], ids=["plain", "faults"])
def test_a_simulated_robot_is_driven_through_the_same_interface(changes):
    run, near = near_run(*changes), Simulation(press(0.05, *changes), prepared())
    for (_, far_record), (_, record) in zip(run.ticks(), near.ticks(), strict=True):
        np.testing.assert_array_equal(far_record["tau"], record["tau"])


class Pusher:
    """Somebody who pushes and turns a gain at a time."""

    paused_s = 0.0

    def before_tick(self, t):
        if t < 0.02:
            return None
        return OperatorRequest(push=(1.0, 0.0, 0.0), push_frame="right_palm", gains={"alpha": 3.0})

    def after_tick(self, t, values):
        self.gains = values["gains"].copy()


def test_a_person_may_turn_gains_and_is_told_that_a_push_is_left_out():
    run, pusher = near_run(), Pusher()
    run.operate(pusher)
    for _ in run.ticks():
        pass
    assert any("alpha: 3" in line for line in run.story)
    assert NO_PUSH in run.story
    assert 3.0 in pusher.gains


def test_a_robot_elsewhere_is_not_begun_with():
    run = near_run()
    robot = run.link
    first = robot.read(0.0)
    for wrong, words in (
        (first._replace(q=first.q + np.r_[np.zeros(7), 0.1, np.zeros(len(first.q) - 8)]), "off by"),
        (first._replace(mode=RobotMode.DRIVEN), "driven already"),
        (first._replace(mode=RobotMode.HELD), "holds itself"),
        (first._replace(stamps=np.full(4, -np.inf)), "does not measure"),
        (None, "No robot was heard"),
    ):
        robot.read = lambda timeout, answer=wrong: answer
        with pytest.raises(RobotLostError, match=words):
            run.meet()


def test_a_robot_that_is_led_away_from_its_posture_lets_its_weight_down():
    """Its servos hold against a small force, and give up a posture that they cannot hold."""
    modes = {}
    for force in (5.0, 800.0):
        push = (
            f"faults.pushes=[{{frame: right_palm, force: [{force}, 0, 0], start: 0, duration: 1}}]"
        )
        scenario = press(0.05, push)
        setup = build_setup(scenario, prepared().robot)
        plant, tau = assemble_plant(scenario, setup, prepared().q_start)
        robot = SimulatedRobot(plant, scenario.control.period, tau)
        for _ in range(300):
            robot.write(RobotCommand(robot.t, CommandMode.HOLD, tau))
        modes[force] = robot.mode
    assert modes == {5.0: RobotMode.HELD, 800.0: RobotMode.SUNK}
