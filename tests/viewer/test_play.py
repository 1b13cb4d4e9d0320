"""Drag and ask: hands follow, higher ones win, and what stops one is named and lit."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("viser", reason="needs the extra 'viewer': pip install -e '.[viewer]'")

from equipoise.errors import InputError, NameNotFoundError
from equipoise.robots import Robot, get_robot
from equipoise.viewer.playing.page import Play, reasons_as_html, speed_in_words
from equipoise.viewer.playing.reason import Reason
from equipoise.viewer.playing.reference import ReferenceSession
from equipoise.viewer.server import ViewerServer


@pytest.fixture(scope="module")
def robot() -> Robot:
    return get_robot("hrp2")


def test_a_hand_follows_and_feet_and_limits_hold(robot: Robot) -> None:
    session = ReferenceSession(robot)
    hand, other = session.hands
    session.drag(hand, session.targets[hand] + [0.12, 0.05, 0.2])
    for _ in range(15):
        q = session.run(0.1)
        joints = q[robot.nq_base :]
        assert (joints > robot.q_min - 1e-9).all()
        assert (joints < robot.q_max + 1e-9).all()
    session.run(0.5)
    assert session.off(hand) < 2e-3
    assert session.off(other) < 2e-3
    start, now = robot.at(robot.q_half_sitting), robot.at(session.q)
    for sole in robot.soles:
        there = start.placement(sole.frame).translation
        assert np.allclose(now.placement(sole.frame).translation, there, atol=1e-6)
    assert session.reason() == Reason()


def test_what_is_out_of_reach_is_said_and_then_stands_still(robot: Robot) -> None:
    session = ReferenceSession(robot)
    hand, _ = session.hands
    session.drag(hand, session.targets[hand] + [2.0, 0.0, 0.0])
    session.run(6.0)
    told = session.reason()
    assert any(sentence.startswith(f"{hand} is 1") for sentence in told.sentences)  # 1.. cm
    assert all("short" in sentence for sentence in told.sentences)
    before = session.q.copy()
    session.run(0.3)
    assert np.abs(session.q - before).max() < 1e-3  # calm, not swinging at its bound
    session.drag(hand, session.targets[hand] - [2.0, 0.0, 0.0])
    session.run(5.0)
    assert session.off(hand) < 2e-3
    assert session.reason() == Reason()


def test_the_first_of_two_hands_that_want_different_things_wins(robot: Robot) -> None:
    """Both are drawn apart further than the arms reach; swapping the order swaps who is short."""
    off = []
    for order in (0, 1):
        session = ReferenceSession(robot)
        hands = session.all_hands[:: 1 - 2 * order]
        session.order(hands)
        left, right = session.all_hands
        session.drag(left, session.targets[left] + [-0.85, 0.0, 0.1])
        session.drag(right, session.targets[right] + [0.85, 0.0, 0.1])
        session.run(5.0)
        off.append([session.off(hand) for hand in hands])
    for first, second in off:
        assert second > 0.02
        assert first < second - 0.02
    with pytest.raises(NameNotFoundError, match="Did you mean 'left_palm'"):
        session.drag("left_pal", np.zeros(3))
    with pytest.raises(InputError):
        session.drag("left_palm", np.full(3, np.nan))


def test_the_page_moves_the_robot_and_lights_what_stops_it(
    robot: Robot, server: ViewerServer
) -> None:
    play = Play(ReferenceSession(robot), server)
    hand = play.session.hands[0]
    assert len(play.orders) == 5  # two orders, together, and each alone
    handle = play.handles[hand]
    handle.position = np.add(handle.position, [0.0, 0.1, 0.15])
    play.session.drag(hand, np.array(handle.position))
    play.session.run(2.0)
    play._asked = -np.inf
    play.show()
    assert play.session.off(hand) < 5e-3
    assert "can follow" in play._said.content
    play._light([12])
    assert play._lit[12]._visible
    play._light([])
    assert not play._lit[12]._visible
    play._reorder("all on one level (weights)")
    assert play.session.together
    play.take_back()
    play.start()
    play.stop()
    start = robot.at(robot.q_half_sitting).placement(hand).translation
    assert np.allclose(play.session.targets[hand], start)


def test_words_are_text_not_markup() -> None:
    assert "<b>" not in reasons_as_html(Reason(("<b>x</b> is 3 cm short.",)))
    assert "Every hand" in reasons_as_html(Reason())
    assert speed_in_words(1.0) == "*At real time.*"
    assert "0.5 × real time" in speed_in_words(0.5)
