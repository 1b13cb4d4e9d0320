"""Robot first: what is held back comes when a page looks, and a person's switch stays."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

pytest.importorskip("viser", reason="needs the extra 'viewer': pip install -e '.[viewer]'")

from equipoise.viewer.server import ViewerServer
from equipoise.viewer.showing import Showable
from equipoise.viewer.unveiling import Unveiling


class Thing(Showable):
    """Remembers whether it is shown."""

    shown = True

    def set_visible(self, visible: bool) -> None:
        self.shown = visible


@pytest.fixture
def held(server: ViewerServer) -> SimpleNamespace:
    first, second, other = Thing(), Thing(), Thing()
    return SimpleNamespace(
        veil=Unveiling(server.viser, (first, second)), first=first, second=second, other=other
    )


def test_things_wait_for_a_page(held: SimpleNamespace) -> None:
    assert (held.first.shown, held.second.shown, held.other.shown) == (False, False, True)
    held.veil.set_visible(held.other, False)
    assert not held.other.shown
    held.veil.open()
    assert held.first.shown
    assert not held.other.shown


def test_what_a_person_hid_stays_hidden(held: SimpleNamespace) -> None:
    held.veil.set_visible(held.first, False)
    held.veil.set_visible(held.second, True)
    assert not held.second.shown
    held.veil.open()
    assert (held.first.shown, held.second.shown) == (False, True)
    held.veil._somebody_left()
    assert not held.second.shown
    held.veil.open()
    assert (held.first.shown, held.second.shown) == (False, True)


def test_after_the_end_nothing_is_touched(held: SimpleNamespace) -> None:
    held.veil.end()
    held.veil.open()
    assert not held.first.shown
