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
from equipoise.wire import RobotLostError, RobotMode, RobotState
from equipoise.wire.health import Health
from equipoise.wire.session import RecordingRobot, SessionRobot
from equipoise.wire.session_file import BEGIN, HEAD, VERSION

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
    with pytest.raises(InputError, match="it begins otherwise"):
        SessionRobot(path, DIGEST)
    path.write_bytes(HEAD.pack(BEGIN, VERSION + 1, DIGEST))
    with pytest.raises(InputError, match="version"):
        SessionRobot(path, DIGEST)
    path.write_bytes(HEAD.pack(BEGIN, VERSION, DIGEST))
    with pytest.raises(InputError, match="no state in it is whole"):
        SessionRobot(path, DIGEST)
    path.unlink()
    driven(lambda controls, model: RecordingRobot(Robot(controls, False), path, DIGEST))
    with pytest.raises(InputError, match="of another robot"):
        SessionRobot(path, DIGEST[::-1])
    with pytest.raises(InputError, match="such a session already"):
        RecordingRobot(SessionRobot(path, DIGEST), path, DIGEST)
    with pytest.raises(InputError, match="no such folder"):
        RecordingRobot(SessionRobot(path, DIGEST), tmp_path / "none" / "session", DIGEST)


class Clock:
    """A clock on which every look takes a hundredth of a second."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        self.now += 0.01
        return self.now


def recorded(path: Path, *, closed: bool) -> np.ndarray:
    """Record a session; without its end, it is as if the program had been killed."""
    links = []

    def connect(controls, model):
        links.append(RecordingRobot(Robot(controls, False), path, DIGEST, Clock()))
        if not closed:
            links[0].close = lambda: None
        return links[0]

    return driven(connect)[1]


def test_what_was_said_is_on_the_disk_before_the_end(tmp_path: Path):
    path = tmp_path / "session"
    given = recorded(path, closed=False)
    replayed = SessionRobot(path, DIGEST)
    assert "was not closed: it breaks off after t = 0.09" in replayed.damage
    states = list(iter_states(replayed))
    assert 96 <= len(states) <= 100
    run = RemoteRun(
        scenario(), lambda *_: SessionRobot(path, DIGEST), lockstep=True, prepared=prepared()
    )
    found = until_over(run)
    np.testing.assert_array_equal(found, given[: len(found)])
    assert len(found) >= 95
    assert run.link.apart == 0.0


def until_over(run: RemoteRun) -> list[np.ndarray]:
    """Return the torques of a run until its session is over."""
    found = []
    try:
        for _, record in run.ticks():
            found.append(record["tau"].copy())
    except RobotLostError:
        return found
    raise AssertionError("the session has no end")


def iter_states(link: SessionRobot):
    while True:
        try:
            yield link.read(0.0)
        except RobotLostError:
            return


def test_a_damaged_end_is_told_and_the_rest_is_read(tmp_path: Path):
    """Wherever a byte is wrong or missing: what comes before is as it was."""
    path, hurt = tmp_path / "session", tmp_path / "hurt"
    recorded(path, closed=True)
    whole = list(iter_states(SessionRobot(path, DIGEST)))
    assert SessionRobot(path, DIGEST).damage == ""
    assert len(whole) == 101
    content, random, lengths = path.read_bytes(), np.random.default_rng(0), []
    for cut in (False, True) * 20:
        at = int(random.integers(HEAD.size, len(content)))
        wrong = bytes([content[at] ^ int(random.integers(1, 256))])
        hurt.write_bytes(content[:at] if cut else content[:at] + wrong + content[at + 1 :])
        try:
            replayed = SessionRobot(hurt, DIGEST)
        except InputError:  # not even the first chunk is whole
            lengths.append(0)
            continue
        assert "damaged" in replayed.damage or "not closed" in replayed.damage
        kept = list(iter_states(replayed))
        lengths.append(len(kept))
        for one, was in zip(kept, whole, strict=False):
            assert (one.sequence, one.t, one.mode) == (was.sequence, was.t, was.mode)
            np.testing.assert_array_equal(one.q, was.q)
    assert max(lengths) > 90 > 10 > min(lengths)


def test_a_disk_that_refuses_ends_the_recording_and_not_the_run(tmp_path: Path):
    folder = tmp_path / "gone"
    folder.mkdir()
    links = []

    def connect(controls, model):
        links.append(RecordingRobot(Robot(controls, False), folder / "session", DIGEST, Clock()))
        folder.rmdir()
        return links[0]

    _, given = driven(connect)
    assert len(given) == 100
    assert "is not whole" in links[0].trouble


def test_parts_may_come_and_go_in_a_session(tmp_path: Path):
    path = tmp_path / "session"
    said = [
        RobotState(k, 0.1 * k, RobotMode.DRIVEN, *(np.full(n, float(k)) for n in (4, 3, 2, 1, 5)),
                   np.full(imu, 7.0), Health(words=np.arange(words)))
        for k, (imu, words) in enumerate([(10, 0), (0, 2), (0, 0), (10, 3), (10, 3)])
    ]  # fmt: skip
    coming = iter(said)
    link = RecordingRobot(Said(coming), path, DIGEST)
    for _ in said:
        link.read(0.0)
    link.close()
    for found, was in zip(iter_states(SessionRobot(path, DIGEST)), said, strict=True):
        for one, other in zip((*found[:9], *found.health), (*was[:9], *was.health), strict=True):
            np.testing.assert_array_equal(one, other)


class Said:
    """A robot that says what it is given."""

    def __init__(self, states) -> None:
        self.states = states

    def read(self, timeout: float) -> RobotState:
        return next(self.states)

    def write(self, command) -> None:
        pass

    def close(self) -> None:
        pass


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
