"""Play with the whole controller: the robot follows, and bears what is done to it, or says so."""

from __future__ import annotations

from importlib.metadata import distributions
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("viser", reason="needs the extra 'viewer': pip install -e '.[viewer]'")

from equipoise.errors import InputError, NameNotFoundError
from equipoise.robots import Robot, get_robot
from equipoise.simulation.build.rehearse import FAR
from equipoise.viewer.playing.footing import NEAR
from equipoise.viewer.playing.live import LiveSession
from equipoise.viewer.playing.page import Play
from equipoise.viewer.playing.walking import FALLS, WalkingSession
from equipoise.viewer.server import ViewerServer
from equipoise.walking import Stick
from example_robots import load_example

needs_mujoco = pytest.mark.skipif(find_spec("mujoco") is None, reason="needs the extra mujoco")
ENGINES = ["rigid", pytest.param("mujoco", marks=needs_mujoco)]


@pytest.fixture(scope="module")
def robot() -> Robot:
    return get_robot("hrp2")


def behind(session: LiveSession) -> float:
    """Return how far [rad] the simulated joints are from the reference, at most."""
    base = session.robot.nq_base
    return float(np.abs(session.q - session.controller.motion.q_ref)[base:].max())


@pytest.mark.parametrize("physics", ENGINES)
def test_the_simulated_hand_follows_and_the_feet_stay(robot: Robot, physics: str) -> None:
    session = LiveSession(robot, physics)
    hand, other = session.hands
    session.drag(hand, session.targets[hand] + [0.03, 0.02, 0.06])
    session.run(1.8)
    assert not session.ended
    assert session.off(hand) < 3e-3
    assert session.off(other) < 3e-3
    start, now = robot.at(robot.q_half_sitting), robot.at(session.q)
    for sole in robot.soles:
        there = start.placement(sole.frame).translation
        assert np.allclose(now.placement(sole.frame).translation, there, atol=1e-3)
    forces = session.forces()
    measured = sum(pressed for _, pressed in forces.values())
    assert abs(measured - robot.mass * 9.81) < 0.02 * robot.mass * 9.81
    for wanted, pressed in forces.values():  # the law's prediction against the sensors
        assert abs(wanted - pressed) < 10.0


def test_a_hand_dragged_out_of_reach_leaves_the_robot_standing(robot: Robot) -> None:
    session = LiveSession(robot, "rigid")
    hand = session.hands[0]
    session.drag(hand, session.targets[hand] + [1.5, 0.0, 0.3])
    for _ in range(45):
        session.run(0.1)
        assert not session.ended
        assert behind(session) < 0.02
    assert session.off(hand) > 0.3
    assert abs(session.controller.motion.q_ref[2] - session.q[2]) < 5e-3


@pytest.mark.parametrize("physics", ENGINES)
def test_it_bears_a_push_and_a_load_and_falls_under_a_blow(robot: Robot, physics: str) -> None:
    session = LiveSession(robot, physics)
    hand = session.hands[0]
    session.push("BODY", np.array([40.0, 0.0, 0.0]))
    session.run(0.1)
    moved = np.abs(session.plant.state.v).max()
    session.run(0.5)
    assert moved > 1e-3  # the push acts
    assert not session.ended
    before = sum(pressed for _, pressed in session.forces().values())
    session.carry(hand, 3.0)
    session.run(0.6)
    after = sum(pressed for _, pressed in session.forces().values())
    assert not session.ended
    assert abs(after - before - 3.0 * 9.81) < 6.0
    session.push("BODY", np.array([900.0, 0.0, 0.0]))
    session.run(1.2)
    assert "mode" in session.ended  # the supervisor's words
    session.restart()
    session.run(0.1)
    assert not session.ended
    assert behind(session) < 0.01


@needs_mujoco
def test_a_slippery_floor_lets_the_feet_go(robot: Robot) -> None:
    """Pushed sideways by more than friction times weight the robot slides; on a rough floor not."""
    slid = []
    for friction in (0.8, 0.05):
        session = LiveSession(robot, "mujoco")
        session.set_friction(friction)
        session.push("BODY", np.array([0.0, 50.0, 0.0]))
        session.run(0.2)
        start = robot.at(robot.q_half_sitting).placement("left_sole").translation
        slid.append(abs(robot.at(session.q).placement("left_sole").translation[1] - start[1]))
    assert slid[0] < 1e-3
    assert slid[1] > 3e-3
    with pytest.raises(InputError, match="Use the engine mujoco"):
        LiveSession(robot, "rigid").set_friction(0.1)


def test_reordering_does_not_jump(robot: Robot) -> None:
    session = LiveSession(robot, "rigid")
    session.drag(session.hands[0], session.targets[session.hands[0]] + [0.1, 0.05, 0.1])
    session.run(0.6)
    tau = session.plant.state.q.copy(), session._command.tau.copy()
    session.order(session.hands[::-1])
    session.run(0.001)
    assert np.abs(session._command.tau - tau[1]).max() < 0.5
    assert np.abs(session.q - tau[0]).max() < 2e-3


@pytest.mark.parametrize("name", ["panda", "solo12"])
def test_what_has_no_palms_is_dragged_by_its_end_or_its_trunk(tmp_path: Path, name: str) -> None:
    if "example-robot-data" not in {one.name for one in distributions()}:
        pytest.skip("needs the extra 'robots'")
    session = LiveSession(load_example(tmp_path, name), "rigid")
    (frame,) = session.all_hands
    assert not session.feet  # soles alone are lifted
    session.drag(frame, session.targets[frame] + [0.01, 0.0, 0.015])
    session.run(1.2)
    assert not session.ended
    assert session.off(frame) < 3e-3


def test_a_dragged_foot_takes_a_step_and_reordering_in_the_air_does_not_jump(robot: Robot) -> None:
    """The weight goes over the other foot first; forces tell that it does, and the floor."""
    session = LiveSession(robot, "rigid")
    weight = 9.81 * robot.mass
    left, right = session.feet
    stood = session.feet[right].copy()
    session.drag_foot(right, stood + np.array([0.0, 0.0, 0.05]))
    for _ in range(42):
        session.run(0.1)
        held = session.forces()[right][1] > 0.05 * weight
        over = session.forces()[left][1] > 0.95 * weight
        assert held or over
        assert not session.ended
    lifted = robot.at(session.q).placement(session.footing.feet[right].frame).translation
    assert np.allclose(lifted, stood + np.array([0.0, 0.0, 0.05]), atol=2e-3)
    assert session.forces()[right] == (0.0, 0.0)
    assert "right_sole is in the air" in session.footing.sentence
    tau = session._command.tau.copy()
    session.order(session.hands[::-1])
    session.run(0.001)
    assert np.abs(session._command.tau - tau).max() < 0.5
    session.drag_foot(right, stood + np.array([0.06, 0.0, -0.05]))
    session.drag_foot(left, session.feet[left] + [0.0, 0.0, 0.1])
    session.run(0.01)
    assert "left_sole must wait" in session.footing.sentence
    session.drag_foot(left, session.feet_at_start[left])
    for _ in range(62):
        session.run(0.1)
        assert not session.ended
    there = robot.at(session.q).placement(session.footing.feet[right].frame).translation
    assert np.allclose(there, stood + np.array([0.06, 0.0, 0.0]), atol=NEAR + 1e-3)
    assert session.footing.sentence == ""
    for _, pressed in session.forces().values():
        assert abs(pressed - 0.5 * weight) < 0.05 * weight
    assert all(session.off(hand) < 5e-3 for hand in session.hands)
    with pytest.raises(NameNotFoundError, match="right_sole"):
        session.drag_foot("right_foot", stood)


def test_what_a_hand_lifts_is_what_was_put_there(robot: Robot) -> None:
    """The motors' torques tell the weight that nobody told the law."""
    session = LiveSession(robot, "rigid")
    hand, other = session.hands
    session.run(0.1)
    assert session.lifted()[hand][1] == pytest.approx(0.0, abs=0.5)
    session.carry(hand, 3.0)
    session.run(0.9)
    wanted, found = session.lifted()[hand]
    assert wanted == pytest.approx(3.0 * 9.81)
    assert found == pytest.approx(wanted, abs=0.3)
    assert session.lifted()[other][1] == pytest.approx(0.0, abs=0.3)


def test_the_page_pushes_loads_and_begins_anew(robot: Robot, server: ViewerServer) -> None:
    play = Play(LiveSession(robot, "rigid"), server)
    panel = play.live
    assert panel is not None
    panel.push()
    play.session.run(0.12)
    play.show()
    assert len(play.feet) == 2
    assert [len(chart.handle.data) for chart in panel.plot.charts] == [5, 5]  # time, two pairs
    assert panel._arrow.visible
    panel.load()
    play.show()
    assert "3 kg in left_palm" in panel._told.content
    panel._try(panel.set_friction, 0.1)
    play.show()
    assert "do not slip" in panel._told.content
    panel.restart()
    assert play.session.t == 0.0
    assert not play.session.plant.loads


def balance_of(session: WalkingSession) -> tuple[float, float]:
    """Return how far [m] the base and [rad] the joints are from the reference."""
    q_ref = session.controller.motion.q_ref
    return float(np.linalg.norm((session.q - q_ref)[:3])), behind(session)


@needs_mujoco
def test_it_walks_while_the_stick_is_held_and_its_hands_can_be_dragged_again(robot: Robot) -> None:
    """From a stand with a hand that was dragged; no torque jumps, and the feet end side by side."""
    session = WalkingSession(robot, "mujoco")
    hand = session.hands[0]
    session.drag(hand, session.targets[hand] + [0.05, 0.02, 0.08])
    session.run(0.8)
    assert session.walk_in_words == ""
    start, said, jump = session.q[0], [], None
    fastest = session.fastest
    assert fastest is not None
    session.stick = Stick(fastest.forward, turn=0.5 * fastest.turn)
    tau = session._command.tau.copy()
    while session.t < 12.0 and (session.walks or session.stick.held):
        if session.t > 4.9:
            session.stick = Stick()
        session.run(0.001 if not session.walks else 0.02)
        if session.walks and jump is None:  # in the tick of the other controller
            jump = np.abs(session._command.tau - tau).max()
        tau = session._command.tau.copy()
        said.append(session.walk_in_words)
        assert not session.ended
        base, joints = balance_of(session)
        assert base < 2e-3
        assert joints < 0.02
    assert jump is not None
    assert 0.0 < jump < 0.5
    for words in ("gets ready", "It walks: the left foot swings", "It stops", "comes to rest"):
        assert any(words in one for one in said), words
    assert session.q[0] - start > 0.9 * fastest.forward * 1.2  # a step, and one that closes
    assert session.off(hand) < 2e-3  # its target went along
    middle = [session.footing.feet[name].T_world_anchor for name in session.feet]
    assert abs(middle[0].actInv(middle[1]).translation[0]) < 2e-3
    session.drag(hand, session.targets[hand] + [0.0, 0.0, -0.04])
    session.run(1.6)
    assert session.off(hand) < 3e-3


def test_steps_are_as_long_as_the_legs_reach_and_what_may_fall_is_told(robot: Robot) -> None:
    """Steps of 0.8 m are tried in mind, and halved; a body that would tip is said to."""
    session = WalkingSession(robot, "rigid")
    spec, period = session._spec, session._make_stroll().walk.planner.period
    session._spec = spec.model_copy(
        update={"stride": spec.stride.model_copy(update={"forward": 0.8})}
    )
    longest = Stick(0.8 / period, session.fastest.left, session.fastest.turn)
    session.stick = longest
    session.run(0.05)
    assert "in its mind" in session.walk_in_words
    session._rehearse(longest)
    found = session._spec.stride.forward
    assert found in (0.4, 0.2, 0.1)
    ready = Stick(found / period, turn=longest.turn * found / 0.8, left=longest.left * found / 0.8)
    behind, room = session._make_stroll().rehearse(session._reference(), ready)
    assert behind <= FAR
    assert ("It may fall" in session._doubt) == (room < -FALLS)
    session.run(0.05)
    assert "gets ready" in session.walk_in_words


def test_who_has_no_two_soles_does_not_walk(tmp_path: Path) -> None:
    if "example-robot-data" not in {one.name for one in distributions()}:
        pytest.skip("needs the extra 'robots'")
    session = WalkingSession(load_example(tmp_path, "solo12"), "rigid")
    assert session.fastest is None
    assert "two soles" in session.why_it_stands
    session.stick = Stick(0.1)
    session.run(0.05)
    assert not session.walks


def test_the_page_has_a_stick_that_is_let_go_with_its_page(
    robot: Robot, server: ViewerServer
) -> None:
    play = Play(WalkingSession(robot, "rigid"), server)
    panel, session = play.stick, play.session
    assert panel is not None
    panel._moved(SimpleNamespace(client_id=7))
    panel._box.value = "0.5, 0 0.1"
    panel._moved(SimpleNamespace(client_id=7))
    assert session.stick == Stick(0.5, 0.0, 0.1)
    session._rehearsed = True
    session.run(0.05)
    play.show()
    assert not any(handle.visible for handle in (*play.handles.values(), *play.feet.values()))
    assert "gets ready to walk" in panel._said.content
    panel._left(SimpleNamespace(client_id=6))
    assert session.stick.held
    panel._left(SimpleNamespace(client_id=7))
    assert not session.stick.held
    play.show()
    assert panel._box.value == "0.000 0.000 0.000"
    panel._box.value = "forwards"
    panel._moved(SimpleNamespace(client_id=7))
    play.show()
    assert "three numbers" in panel._said.content
    play.live.restart()
    play.show()
    assert all(handle.visible for handle in play.handles.values())
    assert not session.walks
