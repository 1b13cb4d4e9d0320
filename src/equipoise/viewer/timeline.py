"""The time line: buttons, slider, speed and keys of a replay."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import partial
from typing import Any, Literal

import viser

from equipoise.viewer.clock import SPEEDS, Clock
from equipoise.viewer.controls import write

JUMP = 0.1  # [s], with shift
Neighbour = Callable[[float], float]
Hotkey = Literal["space", "arrowleft", "arrowright", "home", "end"]
Key = tuple[str, Hotkey, Literal["shift"] | None, Callable[[], None]]


class TimeLine:
    """Steers a clock; `before` and `after` give the time of the neighbouring tick.

    The page's threads take turns: none may act on a time that another has just left.
    """

    def __init__(
        self, gui: viser.GuiApi, clock: Clock, before: Neighbour, after: Neighbour
    ) -> None:
        self._clock, self._before, self._after = clock, before, after
        span = max(clock.last - clock.first, 1e-3)
        self._slider = gui.add_slider(
            "Time [s]", clock.first, clock.first + span, 0.001, clock.first
        )
        self._slider.on_update(self._slid)
        self._written = clock.first
        self._turn = threading.RLock()
        self._buttons = gui.add_button_group("Step", ("|<", "<", ">", ">|"))
        self._buttons.on_click(self._stepped)
        self._play = gui.add_button("Play", icon=viser.Icon.PLAYER_PLAY, hint="space")
        self._play.on_click(lambda _: self.toggle())
        self._speed = gui.add_dropdown(
            "Speed", tuple(f"{speed:g}x" for speed in SPEEDS), initial_value="1x"
        )
        self._speed.on_update(lambda _: clock.set_speed(float(self._speed.value[:-1])))
        self._add_keys(gui)

    def toggle(self) -> None:
        """Play or pause."""
        self._clock.toggle()

    def step(self, direction: int) -> None:
        """Pause and go to the neighbouring tick."""
        with self._turn:
            self._clock.play(False)
            neighbour = self._after if direction > 0 else self._before
            self._clock.seek(neighbour(self._clock.t))

    def jump(self, seconds: float) -> None:
        """Go on or back by some seconds."""
        with self._turn:
            self._clock.seek(self._clock.t + seconds)

    def show(self) -> None:
        """Let slider and button say where the clock stands."""
        with self._turn:
            now = min(max(self._clock.t, self._slider.min), self._slider.max)
            if self._slider.value == self._written != now:  # else a person has just moved it
                self._written = now
                write(self._slider, now)
        label = "Pause" if self._clock.playing else "Play"
        if self._play.label != label:
            self._play.label = label
            paused, playing = viser.Icon.PLAYER_PLAY, viser.Icon.PLAYER_PAUSE
            self._play.icon = playing if self._clock.playing else paused

    def _slid(self, event: viser.GuiEvent[Any]) -> None:
        if event.client_id is not None:  # moved by a person, not by `show`
            with self._turn:
                self._written = self._slider.value
                self._clock.seek(float(self._written))

    def _stepped(self, event: viser.GuiEvent[Any]) -> None:
        clock = self._clock
        actions = {
            "|<": lambda: clock.seek(clock.first),
            "<": lambda: self.step(-1),
            ">": lambda: self.step(1),
            ">|": lambda: clock.seek(clock.last),
        }
        actions[self._buttons.value]()

    def _add_keys(self, gui: viser.GuiApi) -> None:
        keys: tuple[Key, ...] = (
            ("Play or pause", "space", None, self.toggle),
            ("One tick back", "arrowleft", None, lambda: self.step(-1)),
            ("One tick on", "arrowright", None, lambda: self.step(1)),
            ("Back by 0.1 s", "arrowleft", "shift", lambda: self.jump(-JUMP)),
            ("On by 0.1 s", "arrowright", "shift", lambda: self.jump(JUMP)),
            ("To the start", "home", None, lambda: self._clock.seek(self._clock.first)),
            ("To the end", "end", None, lambda: self._clock.seek(self._clock.last)),
        )
        for label, key, modifier, action in keys:
            command = gui.add_command(label, hotkey=key, modifier=modifier)
            command.on_trigger(partial(_act, action))


def _act(action: Callable[[], None], event: viser.CommandEvent) -> None:
    action()
