"""The controls at the sides of the page, which can be shown and hidden together."""

from __future__ import annotations

import viser

from equipoise.viewer.layer import Showable


class Panels(Showable):
    """Rooms for controls: a hidden one costs a page nothing until it is shown."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._gui = gui
        self._rooms: list[viser.GuiFolderHandle] = []
        self._visible = True

    def room(self) -> viser.GuiFolderHandle:
        """Return a new room, to be entered with `with`, where the controls are added now."""
        self._rooms.append(self._gui.add_folder(None, visible=self._visible))
        return self._rooms[-1]

    def set_visible(self, visible: bool) -> None:
        """Show or hide every control."""
        self._visible = visible
        for room in self._rooms:
            room.visible = visible
