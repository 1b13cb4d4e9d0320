"""What can be done to a robot that is played with: push it, load it, take the floor from it."""

from __future__ import annotations

from collections.abc import Callable
from html import escape

import numpy as np
import viser

from equipoise.analysis.rendering.force_arrows import ending
from equipoise.errors import EquipoiseError
from equipoise.kinematics import Kinematics
from equipoise.viewer.base_link import base_link
from equipoise.viewer.forces import PUSH, PUSH_SCALE, add_arrows, draw_arrows
from equipoise.viewer.playing.force_plot import ForcePlot
from equipoise.viewer.playing.live import LiveSession
from equipoise.viewer.playing.plant import PUSH_TIME

WAYS = {
    "forwards": (1.0, 0.0, 0.0),
    "backwards": (-1.0, 0.0, 0.0),
    "to its left": (0.0, 1.0, 0.0),
    "to its right": (0.0, -1.0, 0.0),
    "down": (0.0, 0.0, -1.0),
}
MOST_PUSH = 300.0  # [N]
USUAL_PUSH = 0.7  # [N/kg] that a robot stands without a step
LOAD = 3.0  # [kg]
MOST_LOAD = 10.0  # [kg]
FLOOR = 0.8  # friction at first
SHOWN_PUSH = 0.5  # [s] for which a push stays drawn, too short to see otherwise


TEXT = "margin: 0.4em 1em; font-size: 0.875em; line-height: 1.4"


class LivePanel:
    """The controls of a live session; `take_back` puts the handles where they were at first."""

    def __init__(
        self, server: viser.ViserServer, session: LiveSession, take_back: Callable[[], None]
    ) -> None:
        self._server, self.session, self._take_back = server, session, take_back
        gui = server.gui
        self._told = gui.add_html("")
        self._add_push(gui)
        self._add_load(gui)
        if session.plant.slips:
            floor = gui.add_slider("Friction of the floor", 0.02, 1.0, 0.02, FLOOR)
            floor.on_update(lambda event: self._try(self.set_friction, float(event.target.value)))
        again = gui.add_button("Begin anew", icon=viser.Icon.REFRESH)
        again.on_click(lambda _: self.restart())
        self.plot = ForcePlot(gui, session)
        self._arrow = add_arrows(server.scene, "/push", PUSH)
        self._pushed_at = -np.inf
        self._refused = ""

    @property
    def pushed(self) -> bool:
        """Whether somebody has pushed it since it began."""
        return bool(np.isfinite(self._pushed_at))

    def push(self) -> None:
        """Push as the controls say."""
        force = float(self._force.value) * np.array(WAYS[str(self._way.value)])
        self.session.push(str(self._where.value), force)
        self._pushed_at = self.session.t

    def load(self) -> None:
        """Put the mass into the hand that the controls say."""
        self.session.carry(str(self._hand.value), float(self._mass.value))

    def set_friction(self, friction: float) -> None:
        """Change the floor."""
        self.session.set_friction(friction)

    def restart(self) -> None:
        """Let the robot stand as it did at first."""
        self.session.restart()
        self._take_back()
        self._refused, self._pushed_at = "", -np.inf
        self.plot.clear()

    def show(self, kin: Kinematics) -> None:
        """Draw the push, the forces, and say what stands in the way of going on."""
        t = self.session.t
        arrows = []
        if 0.0 <= t - self._pushed_at < SHOWN_PUSH:
            force = float(self._force.value) * np.array(WAYS[str(self._way.value)])
            at = kin.placement(str(self._where.value)).translation
            arrows = [ending(at, PUSH_SCALE * force)]
        if arrows or self._arrow.visible:
            draw_arrows(self._arrow, arrows)
            self._arrow.visible = bool(arrows)
        self.plot.show()
        text = state_as_html(self.session, self._refused)
        if text != self._told.content:
            self._told.content = text

    def _add_push(self, gui: viser.GuiApi) -> None:
        robot = self.session.robot
        frames = [base_link(robot)] if robot.nv_base else []
        frames += self.session.all_hands
        usual = float(np.clip(5.0 * round(USUAL_PUSH * robot.mass / 5.0), 5.0, MOST_PUSH))
        with gui.add_folder("Push"):
            self._where = gui.add_dropdown("At", tuple(dict.fromkeys(frames)))
            self._way = gui.add_dropdown("Which way", tuple(WAYS))
            self._force = gui.add_slider("Force [N]", 5.0, MOST_PUSH, 5.0, usual)
            button = gui.add_button(f"Push for {PUSH_TIME:g} s")
            button.on_click(lambda _: self._try(self.push))

    def _add_load(self, gui: viser.GuiApi) -> None:
        with gui.add_folder("Load that the law is not told of"):
            self._hand = gui.add_dropdown("In", self.session.all_hands)
            self._mass = gui.add_slider("Mass [kg]", 0.0, MOST_LOAD, 0.5, LOAD)
            button = gui.add_button("Put it there")
            button.on_click(lambda _: self._try(self.load))

    def _try(self, act: Callable[..., None], *given: float) -> None:
        """Do what a person asks for; what cannot be done is said on the page."""
        try:
            act(*given)
            self._refused = ""
        except EquipoiseError as error:
            self._refused = str(error)


def state_as_html(session: LiveSession, refused: str) -> str:
    """Return how the controller fares, in words."""
    loads = ", ".join(f"{mass:g} kg in {name}" for name, mass in session.plant.loads.items())
    lines = [f"The law runs, {session.physics_in_words}."]
    if session.ended:
        lines = [f"The law was switched off: {session.ended}. “Begin anew” lets it stand again."]
    lines += [session.footing.sentence] if session.footing and session.footing.sentence else []
    lines += [f"It carries {loads}."] if loads else []
    lines += [refused] if refused else []
    colour = "#b3261e" if session.ended or refused else "inherit"
    text = "<br>".join(escape(line) for line in lines)
    return f'<p style="{TEXT}; color: {colour}" id="equipoise-live">{text}</p>'
