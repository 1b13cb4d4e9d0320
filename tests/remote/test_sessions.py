"""Sessions: written down and read again, ended by a robot that must not go on."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from equipoise.errors import InputError
from equipoise.estimation import EstimatingRobot
from equipoise.remote.drive import RemoteRun
from equipoise.scenarios import read_scenario
from equipoise.simulation.build.assemble import Prepared, assemble_plant, starting_posture
from equipoise.simulation.build.setup import build_setup
from equipoise.simulation.simulated_robot import SimulatedRobot
from equipoise.wire import RobotLostError, RobotState
from equipoise.wire.health import Health
from equipoise.wire.session import RecordingRobot, SessionRobot

DIGEST = b"0123456789abcdef"


@cache
def scenario():
    return read_scenario("press", ["duration=0.1"])


@cache
def prepared() -> Prepared:
    setup = build_setup(scenario())
    return Prepared(setup.robot, starting_posture(scenario(), setup))


class Robot:
    """A simulated robot; without sensors of base and contacts, if so wanted; one state is unfit."""

    def __init__(self, controls, blind: bool, unfit_at: float = np.inf, health=None) -> None:
        plant, tau = assemble_plant(controls.scenario, controls.setup, controls.q_start)
        self.robot = SimulatedRobot(plant, controls.scenario.control.period, tau)
        self.blind, self.unfit_at, self.health, self.closed = blind, unfit_at, health, 0
        self.written: list[float] = []

    def read(self, timeout: float) -> RobotState | None:
        state = self.robot.read(timeout)
        if state is not None and self.blind:
            q, v = state.q.copy(), state.v.copy()
            q[:7], v[:6] = np.nan, np.nan
            stamps = np.array([-np.inf, state.t, -np.inf, state.t])
            lam = np.full_like(state.lam, np.nan)
            state = state._replace(q=q, v=v, lam=lam, stamps=stamps)
        if state is not None and state.t >= self.unfit_at:
            state = state._replace(health=self.health)
        return state

    def write(self, command) -> None:
        self.written.append(command.t)
        self.robot.write(command)

    def close(self) -> None:
        self.closed += 1


def estimating(link, controls):
    setup = controls.setup
    return EstimatingRobot(link, setup.robot, setup.contacts, setup.schedule)


def driven(connect) -> tuple[RemoteRun, np.ndarray]:
    run = RemoteRun(scenario(), connect, lockstep=True, prepared=prepared())
    return run, np.array([record["tau"].copy() for _, record in run.ticks()])


@pytest.mark.parametrize("blind", [False, True])
def test_a_session_that_is_read_again_gives_the_same_torques(tmp_path: Path, blind):
    """Base and forces measured, or estimated from the recorded joints and inertial unit."""
    path = tmp_path / "session"

    def first(controls, model):
        link = RecordingRobot(Robot(controls, blind), path, DIGEST)
        return estimating(link, controls) if blind else link

    _, given = driven(first)
    assert len(given) == 100
    replayed = SessionRobot(path, DIGEST)
    assert replayed.measures_base is not blind

    def again(controls, model):
        return estimating(replayed, controls) if blind else replayed

    _, found = driven(again)
    np.testing.assert_allclose(found, given, rtol=1e-12, atol=1e-12)
    assert replayed.compared == 100
    assert replayed.apart < 1e-9
    assert "100 commands" in replayed.sentence()


def test_another_command_is_noticed(tmp_path: Path):
    path = tmp_path / "session"
    driven(lambda controls, model: RecordingRobot(Robot(controls, False), path, DIGEST))
    other = read_scenario("press", ["duration=0.1", "control.gains.alpha=9.0"])
    replayed = SessionRobot(path, DIGEST)
    run = RemoteRun(other, lambda *_: replayed, lockstep=True, prepared=prepared())
    for _ in run.ticks():
        pass
    assert replayed.apart > 1e-6


def test_what_is_no_session_of_this_robot_is_refused(tmp_path: Path):
    path = tmp_path / "session"
    with pytest.raises(InputError, match="is no session"):
        SessionRobot(path, DIGEST)
    path.write_bytes(b"PK\3\4 nothing")
    with pytest.raises(InputError, match="is no session"):
        SessionRobot(path, DIGEST)
    with path.open("wb") as out:
        np.save(out, np.zeros(3))
    with pytest.raises(InputError, match="is no session"):
        SessionRobot(path, DIGEST)
    driven(lambda controls, model: RecordingRobot(Robot(controls, False), path, DIGEST))
    with pytest.raises(InputError, match="of another robot"):
        SessionRobot(path, DIGEST[::-1])
    with pytest.raises(InputError, match="no such folder"):
        RecordingRobot(SessionRobot(path, DIGEST), tmp_path / "none" / "session", DIGEST)


def test_a_session_ends(tmp_path: Path):
    path = tmp_path / "session"
    driven(lambda controls, model: RecordingRobot(Robot(controls, False), path, DIGEST))
    longer = read_scenario("press", ["duration=0.2"])
    run = RemoteRun(
        longer, lambda *_: SessionRobot(path, DIGEST), lockstep=True, prepared=prepared()
    )
    with pytest.raises(RobotLostError, match="session is over"):
        for _ in run.ticks():
            pass


@pytest.mark.parametrize(
    ("health", "why"),
    [(Health(stop=True), "stop on its remote"), (Health(np.full(30, 95.0)), "95 deg C")],
)
def test_a_robot_that_must_not_go_on_is_let_go_at_once(health, why):
    robots = []

    def connect(controls, model):
        robots.append(Robot(controls, False, 0.05, health))
        return robots[0]

    with pytest.raises(RobotLostError, match=why):
        driven(connect)
    assert robots[0].closed
    assert max(robots[0].written) == pytest.approx(0.049)


def test_a_robot_that_is_not_fit_is_not_begun_with():
    run = RemoteRun(
        scenario(),
        lambda controls, model: Robot(controls, False, 0.0, Health(np.full(30, 75.0))),
        lockstep=True,
        prepared=prepared(),
    )
    with pytest.raises(RobotLostError, match="not fit to be driven"):
        run.meet()
    assert run.link.written == []
