"""The controls at the sides of the page, which can be shown and hidden together."""

from __future__ import annotations

import viser

from equipoise.viewer.layer import Showable


class Panels(Showable):
    """Groups of controls: a hidden one costs a page nothing until it is shown."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._gui = gui
        self._groups: list[viser.GuiFolderHandle] = []
        self._visible = True

    def group(self) -> viser.GuiFolderHandle:
        """Return a new group, to be entered with `with`, where the controls are added now."""
        self._groups.append(self._gui.add_folder(None, visible=self._visible))
        return self._groups[-1]

    def set_visible(self, visible: bool) -> None:
        """Show or hide every control."""
        self._visible = visible
        for group in self._groups:
            group.visible = visible
