"""Robot first: what a page needs long to set up comes once the page has drawn the rest."""

from __future__ import annotations

import threading
from collections.abc import Sequence

import viser

from equipoise.viewer.layer import Showable
from equipoise.viewer.page_ready import has_drawn


class ProgressiveDisplay:
    """Keeps items hidden while nobody looks, and shows them step by step.

    A step of `steps` is shown when a page has drawn all that came before. A switch goes through
    `set_visible`, so that what a person hid stays hidden. Thin lines, arrows and balls each need
    programs that a browser translates before it draws anything, and a control takes it longer
    than a mesh.
    """

    def __init__(self, server: viser.ViserServer, steps: Sequence[Sequence[Showable]]) -> None:
        self._server, self._steps = server, steps
        self._wanted = {item: True for step in steps for item in step}
        self._shown: set[Showable] = set()
        self._ended = False
        self._lock = threading.RLock()
        for item in self._wanted:
            item.set_visible(False)
        server.on_client_connect(self._somebody_looks)
        server.on_client_disconnect(lambda _: self._somebody_left())

    def set_visible(self, item: Showable, visible: bool) -> None:
        """Show or hide an item; one of those that are held back as soon as it may be seen."""
        with self._lock:
            if item in self._wanted:
                self._wanted[item] = visible
                visible = visible and item in self._shown
            if not self._ended:
                item.set_visible(visible)

    @property
    def opened(self) -> bool:
        """Whether everything that is wanted is shown."""
        return len(self._shown) == len(self._wanted)

    def end(self) -> None:
        """Touch the items no more: they are about to be removed."""
        with self._lock:
            self._ended = True

    def open(self, step: Sequence[Showable]) -> None:
        """Show what is wanted of a step."""
        with self._lock:
            if not self._ended:
                self._set([item for item in step if item not in self._shown], True)

    def _somebody_looks(self, client: viser.ClientHandle) -> None:
        threading.Thread(target=self._show_in_steps, args=(client,), daemon=True).start()

    def _show_in_steps(self, client: viser.ClientHandle) -> None:
        """Open step after step, as fast as this page draws them."""
        for step in self._steps:
            if self._ended or self.opened or not has_drawn(client):
                return
            self.open(step)

    def _somebody_left(self) -> None:
        with self._lock:
            if not self._ended and not self._server.get_clients():
                self._set(list(self._shown), False)

    def _set(self, items: Sequence[Showable], shown: bool) -> None:
        with self._server.atomic():
            for item in items:
                (self._shown.add if shown else self._shown.discard)(item)
                item.set_visible(shown and self._wanted[item])
