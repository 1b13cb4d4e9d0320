"""The stick of a page: a pad to drag, keys, or numbers; and what the walk does, in words."""

from __future__ import annotations

from html import escape

import viser

from equipoise.errors import InputError
from equipoise.viewer.controls import write
from equipoise.viewer.playing.walking import WalkingSession
from equipoise.walking import Stick

NOTHING = "0.000 0.000 0.000"
TEXT = "margin: 0.4em 1em; font-size: 0.875em; line-height: 1.4"
STYLE = """<style>
#equipoise-stick { margin: 0.5em 1em; user-select: none; -webkit-user-select: none; }
#equipoise-stick [data-part] { position: relative; display: flex; align-items: center;
  justify-content: center; margin: 0 auto 0.5em; border: 1px solid #8a929a; touch-action: none;
  background: rgba(127, 140, 150, 0.14); cursor: grab; }
#equipoise-stick [data-part]:focus-visible { outline: 3px solid #228be6; outline-offset: 1px; }
#equipoise-stick [data-part="pad"] { width: 9em; height: 9em; border-radius: 50%; }
#equipoise-stick [data-part="strip"] { width: 9em; height: 2.2em; border-radius: 1.1em; }
#equipoise-stick [data-part] > span { width: 2.2em; height: 2.2em; border-radius: 50%;
  background: #228be6; pointer-events: none; }
#equipoise-stick p { margin: 0.2em 0 0; font-size: 0.8em; line-height: 1.4; text-align: center; }
</style>"""
PAD = (
    "Stick to walk with. Up and W: forwards, down and S: backwards, left and A, right and D: turn, "
    "Q and E: sideways"
)
STRIP = "Steps sideways: drag to the left or right, or hold Q or E"
HINT = (
    "Drag: up walks forwards, aside turns. Below: sideways. Or click it and hold "
    "<b>W A S D</b>, arrows, <b>Q E</b>. Let go, and it stops."
)


class StickPanel:
    """The controls of a robot that walks; `session.fastest` must not be None."""

    def __init__(self, server: viser.ViserServer, session: WalkingSession) -> None:
        self.session = session
        self._holder: int | None = None  # the page that moved the stick last
        self._refused, self._stale = "", False  # the box says what nobody holds any more
        gui = server.gui
        with gui.add_folder("Walk"):
            gui.add_html(pad_as_html(session))
            self._box = gui.add_text(
                "Speed", NOTHING,
                hint="forwards [m/s], to the left [m/s], turning to the left [rad/s]",
            )  # fmt: skip
            self._said = gui.add_html(self._words())
        self._box.on_update(self._moved)
        server.on_client_disconnect(self._left)

    def release(self) -> None:
        """Let the stick go."""
        self.session.stick = Stick()
        write(self._box, NOTHING)

    def show(self) -> None:
        """Say what the walk does."""
        if self._stale:
            self._stale = False
            write(self._box, NOTHING)
        words = self._words()
        if words != self._said.content:
            self._said.content = words

    def _moved(self, event: viser.GuiEvent[viser.GuiTextHandle]) -> None:
        self._holder = event.client_id
        try:
            self.session.stick = stick_of(str(self._box.value))
            self._refused = ""
        except InputError as error:
            self.session.stick = Stick()
            self._refused = str(error)

    def _left(self, client: viser.ClientHandle) -> None:
        """Let the stick go with the page that held it."""
        if client.client_id == self._holder:
            self.session.stick, self._stale = Stick(), True

    def _words(self) -> str:
        said = self.session.walk_in_words or "It stands; hold the stick, and it walks."
        text = escape(" ".join(one for one in (said, self._refused) if one))
        return f'<p style="{TEXT}" id="equipoise-walk" role="status" aria-live="polite">{text}</p>'


def stick_of(text: str) -> Stick:
    """Return the stick that three numbers say. Raises: `InputError`."""
    parts = text.replace(",", " ").split()
    try:
        values = [float(one) for one in parts]
    except ValueError:
        values = []
    if len(values) != 3:
        raise InputError(
            "how fast to walk is three numbers: forwards [m/s], to the left [m/s], turning [rad/s]",
            given=text,
        )
    return Stick(*values)


def pad_as_html(session: WalkingSession) -> str:
    """Return the pad and the strip; a script of the page moves them."""
    fastest = session.fastest
    assert fastest is not None
    most = " ".join(
        f'data-{name}="{getattr(fastest, name):.4f}"' for name in ("forward", "left", "turn")
    )
    return (
        f'{STYLE}<div id="equipoise-stick" {most}>'
        f'<div data-part="pad" tabindex="0" role="application" aria-label="{PAD}">'
        "<span></span></div>"
        f'<div data-part="strip" tabindex="0" role="application" aria-label="{STRIP}">'
        f"<span></span></div><p>{HINT}</p></div>"
    )
