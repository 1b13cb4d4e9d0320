"""Robot first: what a page needs long to set up comes once the page has drawn the rest."""

from __future__ import annotations

import threading
from collections.abc import Sequence

import viser

from equipoise.viewer.showing import Showable

AFTER = 1.0  # [s] from a page's first word to its first picture, about (drawn without a GPU)


class Unveiling:
    """Keeps `things` hidden while nobody looks, and shows them when a page has drawn the rest.

    A switch goes through `set_visible`, so that what a person hid stays hidden. Thin lines, arrows
    and balls each need programs that a browser translates before it draws anything.
    """

    def __init__(self, server: viser.ViserServer, things: Sequence[Showable]) -> None:
        self._server = server
        self._wanted = dict.fromkeys(things, True)
        self._open, self._ended = False, False
        self._lock = threading.RLock()
        for thing in things:
            thing.set_visible(False)
        server.on_client_connect(lambda _: self._somebody_looks())
        server.on_client_disconnect(lambda _: self._somebody_left())

    def set_visible(self, thing: Showable, visible: bool) -> None:
        """Show or hide a thing; one of those that are held back as soon as it may be seen."""
        with self._lock:
            if thing in self._wanted:
                self._wanted[thing] = visible
                visible = visible and self._open
            if not self._ended:
                thing.set_visible(visible)

    @property
    def opened(self) -> bool:
        """Whether everything that is wanted is shown."""
        return self._open

    def end(self) -> None:
        """Touch the things no more: they are about to be removed."""
        with self._lock:
            self._ended = True

    def open(self) -> None:
        """Show what is wanted."""
        self._set(True)

    def _somebody_looks(self) -> None:
        timer = threading.Timer(AFTER, self.open)
        timer.daemon = True
        timer.start()

    def _somebody_left(self) -> None:
        if not self._server.get_clients():
            self._set(False)

    def _set(self, opened: bool) -> None:
        with self._lock:
            if self._ended or opened == self._open:
                return
            self._open = opened
            with self._server.atomic():
                for thing, wanted in self._wanted.items():
                    thing.set_visible(opened and wanted)
