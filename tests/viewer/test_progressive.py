"""Robot first: what is held back comes when a page looks, and a person's switch stays."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

pytest.importorskip("viser", reason="needs the extra 'viewer': pip install -e '.[viewer]'")

from equipoise.viewer.layer import Showable
from equipoise.viewer.page_ready import has_begun_frame, has_drawn
from equipoise.viewer.panels import Panels
from equipoise.viewer.progressive import ProgressiveDisplay
from equipoise.viewer.server import ViewerServer


class Thing(Showable):
    """Remembers whether it is shown."""

    shown = True

    def set_visible(self, visible: bool) -> None:
        self.shown = visible


@pytest.fixture
def held(server: ViewerServer) -> SimpleNamespace:
    first, second, third, other = Thing(), Thing(), Thing(), Thing()
    veil = ProgressiveDisplay(server.viser, ((first, second), (third,)))
    return SimpleNamespace(veil=veil, first=first, second=second, third=third, other=other)


def shown(held: SimpleNamespace) -> tuple[bool, bool, bool]:
    return held.first.shown, held.second.shown, held.third.shown


def test_things_wait_for_a_page_step_by_step(held: SimpleNamespace) -> None:
    assert shown(held) == (False, False, False)
    assert held.other.shown
    held.veil.set_visible(held.other, False)
    assert not held.other.shown
    held.veil.open((held.first, held.second))
    assert shown(held) == (True, True, False)
    assert not held.veil.opened
    held.veil.open((held.third,))
    assert shown(held) == (True, True, True)
    assert held.veil.opened
    assert not held.other.shown


def test_a_step_comes_when_the_page_has_drawn_the_one_before(
    held: SimpleNamespace, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = []

    def has_drawn(client: object) -> bool:
        seen.append(shown(held))
        return client == "one that stays" or len(seen) < 2

    monkeypatch.setattr("equipoise.viewer.progressive.has_drawn", has_drawn)
    held.veil._show_in_steps("one that leaves after the first step")
    assert seen == [(False, False, False), (True, True, False)]
    assert shown(held) == (True, True, False)
    held.veil._somebody_left()
    assert shown(held) == (False, False, False)
    held.veil._show_in_steps("one that stays")
    assert shown(held) == (True, True, True)


def test_what_a_person_hid_stays_hidden(held: SimpleNamespace) -> None:
    step = (held.first, held.second)
    held.veil.set_visible(held.first, False)
    held.veil.set_visible(held.second, True)
    assert not held.second.shown
    held.veil.open(step)
    assert (held.first.shown, held.second.shown) == (False, True)
    held.veil._somebody_left()
    assert not held.second.shown
    held.veil.open(step)
    assert (held.first.shown, held.second.shown) == (False, True)


def test_after_the_end_nothing_is_touched(held: SimpleNamespace) -> None:
    held.veil.end()
    held.veil.open((held.first,))
    assert not held.first.shown


def test_a_page_that_does_not_answer_is_not_waited_for_and_one_that_left_is_told() -> None:
    """What the page's answer is does not matter: a refusal to store anything is one too."""
    answers = {
        "nothing stored": (None, True),
        "slow": (TimeoutError("request timed out"), True),
        "forbidden": (RuntimeError("Failed to read localStorage: SecurityError"), True),
        "gone": (RuntimeError("localStorage request failed: the client disconnected"), False),
    }
    for what, (answer, there) in answers.items():

        def get_item(key: str, timeout: float, answer: object = answer) -> None:
            if isinstance(answer, Exception):
                raise answer

        page = SimpleNamespace(local_storage=SimpleNamespace(get_item=get_item))
        assert has_begun_frame(page, 0.1) is there, what
        assert has_drawn(page) is there, what


def test_controls_are_hidden_with_their_rooms(server: ViewerServer) -> None:
    panels = Panels(server.viser.gui)
    early = panels.group()
    panels.set_visible(False)
    late = panels.group()
    assert (early.visible, late.visible) == (False, False)
    panels.set_visible(True)
    assert (early.visible, late.visible) == (True, True)
