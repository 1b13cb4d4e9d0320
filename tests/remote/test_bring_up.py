"""A robot that stands otherwise is brought to the start by its servos, and then driven."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from equipoise.remote.bring_up import FAR, FASTEST, SETTLING, SPEED, BroughtUp
from equipoise.remote.drive import RemoteRun
from equipoise.remote.far_end import FarEnd, FarEndSettings
from equipoise.scenarios import read_scenario
from equipoise.simulation.build.assemble import Prepared, assemble_plant, starting_posture
from equipoise.simulation.build.setup import build_setup
from equipoise.simulation.simulated_robot import SimulatedRobot
from equipoise.wire import CommandMode, RobotCommand, RobotLostError, RobotMode

MOVED = ("right_shoulder_pitch_joint", "right_elbow_joint", "left_wrist_roll_joint")


@cache
def scenario():
    return read_scenario("press", ["duration=0.1", "physics.engine=mujoco"], robot="g1")


@cache
def prepared() -> Prepared:
    setup = build_setup(scenario())
    return Prepared(setup.robot, starting_posture(scenario(), setup))


def elsewhere(by: float) -> SimulatedRobot:
    """Return a robot that stands with some joints of its arms off by `by` [rad]."""
    setup, q = build_setup(scenario(), prepared().robot), prepared().q_start.copy()
    robot = setup.robot
    for name in MOVED:
        joint = robot.joint_names.index(name)
        k = robot.nq_base + joint
        q[k] += by if q[k] + by < robot.q_max[joint] else -by
    plant, tau = assemble_plant(scenario(), setup, q)
    return SimulatedRobot(plant, scenario().control.period, tau)


def brought(link, clock=None) -> BroughtUp:
    joints = prepared().q_start[prepared().robot.nq_base :]
    return BroughtUp(link, prepared().robot, joints, **({"clock": clock} if clock else {}))


class Watched:
    """A link that keeps what it is told and what it says."""

    def __init__(self, robot: SimulatedRobot) -> None:
        self.robot, self.told, self.said = robot, [], []

    def read(self, timeout: float):
        state = self.robot.read(timeout)
        if state is not None:
            self.said.append(state)
        return state

    def write(self, command) -> None:
        self.told.append(command)
        self.robot.write(command)

    def close(self) -> None:
        pass


def test_it_is_led_slowly_and_then_driven_from_time_zero():
    link = Watched(elsewhere(0.2))
    run = RemoteRun(scenario(), lambda *_: brought(link), lockstep=True, prepared=prepared())
    assert any("stands where it should" in sentence for sentence in run.meet())
    led = [one for one in link.told if one.mode is CommandMode.POSTURE]
    assert len(led) == len(link.told)  # no torque until it is driven
    speeds = np.diff([one.posture for one in led], axis=0) / scenario().control.period
    assert np.abs(speeds).max() == pytest.approx(min(SPEED, FASTEST * 0.2), rel=0.3)
    assert np.abs(speeds[[0, -1]]).max() < 0.05
    off = prepared().q_start[7:] - link.robot.q[7:]
    assert np.abs(off).max() < 0.01
    assert {state.mode for state in link.said} == {RobotMode.WAITING}
    assert np.abs(link.robot.q[:3] - prepared().q_start[:3]).max() < 0.005
    takes = max(FASTEST * 0.2 / SPEED, 1.0) + SETTLING
    assert link.robot.t == pytest.approx(takes, abs=0.01)
    times = [t for t, _ in run.ticks()]
    assert len(times) == 100
    assert times[0] == 0.0
    driven = [one.t for one in link.told if one.mode is CommandMode.TORQUE]
    assert driven[0] == pytest.approx(takes, abs=0.01)
    assert run.controller.supervisor.mode.name == "RUN"


def test_who_stands_right_or_too_far_off_is_not_moved():
    for by in (0.0, FAR + 0.1):
        link = Watched(elsewhere(by))
        robot = brought(link)
        assert robot.read(0.0).t == 0.0
        assert link.told == []
        assert not robot.told


def test_a_robot_that_does_not_follow_is_let_be():
    link = Watched(elsewhere(0.8))
    link.robot.write = lambda command: setattr(link.robot, "_ticks", link.robot._ticks + 1)
    with pytest.raises(RobotLostError, match="does not follow its servos"):
        brought(link).read(0.0)


class Heard:
    """A `RobotServer` that hears given commands at given ticks of a robot in real time."""

    def __init__(self, commands: dict[int, RobotCommand]) -> None:
        self.commands, self.tick, self.dropped, self.sent = commands, 0, {}, []

    def now(self) -> float:
        return 0.0

    def receive(self, t: float):
        self.tick += 1
        return self.commands.get(self.tick)

    def send(self, state):
        self.sent.append(state)
        return state


def test_servos_need_nobody_but_a_torque_does():
    """In real time: a posture is kept through a silence, a torque is not; nor is one gone back."""
    robot = elsewhere(0.2)
    posture = robot.q[7:].copy()
    na = posture.size
    commands = {
        1: RobotCommand(0.0, CommandMode.POSTURE, np.zeros(na), posture),
        200: RobotCommand(0.0, CommandMode.TORQUE, robot.read(0.0).tau),
        205: RobotCommand(0.0, CommandMode.POSTURE, np.zeros(na), posture),
    }
    server = Heard(commands)
    far_end = FarEnd(robot, server, FarEndSettings(lockstep=False, watched=0.01))
    for _ in range(199):
        far_end.tick()
    assert robot.mode is RobotMode.WAITING
    assert robot.t == pytest.approx(0.199)
    assert np.abs(robot.q[7:] - posture).max() < 0.05
    for _ in range(10):
        far_end.tick()
    assert robot.mode is RobotMode.DRIVEN
    for _ in range(60):
        far_end.tick()
    assert "nothing was heard" in far_end.cause
