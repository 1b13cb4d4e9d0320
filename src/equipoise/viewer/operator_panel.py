"""The controls of a running simulation: pause, step, stop, push, gains and wanted forces."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import numpy as np
import viser

from equipoise.scenarios import schema
from equipoise.simulation.build.setup import Setup
from equipoise.simulation.operator import GAIN_UNITS, OperatorRequest
from equipoise.viewer.controls import write

MOST_PUSH = 150.0  # [N]
MOST_FORCE = 30.0  # [N], added to a wanted force
SEVERAL = 50  # ticks of the longer step
Send = Callable[[str, object], None]


class OperatorPanel:
    """Turns what a person moves into messages for the run."""

    def __init__(
        self, gui: viser.GuiApi, scenario: schema.Scenario, setup: Setup, frame: str, send: Send
    ) -> None:
        self._gui, self._send = gui, send
        self._turn = threading.RLock()  # the page's threads act one by one
        self._running = True
        self._told = OperatorRequest()
        self._time = gui.add_text("Time", "0.000 s", disabled=True)
        self._pause = gui.add_button("Pause", icon=viser.Icon.PLAYER_PAUSE, hint="space")
        self._pause.on_click(lambda _: self.toggle())
        steps = gui.add_button_group("Step", ("1 tick", f"{SEVERAL} ticks"))
        steps.on_click(lambda _: self.step(1 if steps.value == "1 tick" else SEVERAL))
        stop = gui.add_button("Stop the run", color="red", icon=viser.Icon.PLAYER_STOP)
        stop.on_click(lambda _: send("stop", None))
        gui.add_command("Pause or go on", hotkey="space").on_trigger(lambda _: self.toggle())
        gui.add_command("One tick", hotkey="arrowright").on_trigger(lambda _: self.step(1))
        self._given = {name: float(getattr(scenario.control.gains, name)) for name in GAIN_UNITS}
        self._gains: dict[str, viser.GuiNumberHandle[float]] = {}
        self._forces: dict[str, viser.GuiSliderHandle[float]] = {}
        self._add_push(setup, frame)
        self._add_forces(setup)
        self._add_gains()

    def show(self, t: float) -> None:
        """Show the time [s] of the run."""
        write(self._time, f"{t:.3f} s")

    def toggle(self) -> None:
        """Pause or go on, under what stands in the controls."""
        with self._turn:
            self._send_request()
            self._set_running(not self._running)
            self._send("run", self._running)

    def step(self, ticks: int) -> None:
        """Pause after some more ticks, under what stands in the controls."""
        with self._turn:
            self._send_request()
            self._set_running(False)
            self._send("step", ticks)

    @property
    def request(self) -> OperatorRequest:
        """What stands in the controls now."""
        x, y, z = (float(slider.value) for slider in self._push)
        gains = {name: float(box.value) for name, box in self._gains.items()}
        forces = {name: float(slider.value) for name, slider in self._forces.items()}
        return OperatorRequest(
            push=(x, y, z),
            push_frame=self._frame.value if any((x, y, z)) else "",
            damping_factor=float(self._damping.value),
            gains={name: value for name, value in gains.items() if value != self._given[name]},
            forces={name: value for name, value in forces.items() if value},
        )

    def _add_push(self, setup: Setup, frame: str) -> None:
        robot, gui = setup.robot, self._gui
        frames = [frame, *(palm.frame for palm in robot.palms)]
        with gui.add_folder("Push [N]"):
            self._frame = gui.add_dropdown("At", tuple(frames), initial_value=frame)
            self._push = [
                gui.add_slider(axis, -MOST_PUSH, MOST_PUSH, 1.0, 0.0) for axis in ("x", "y", "z")
            ]
            none = gui.add_button("No push")
        none.on_click(lambda _: self._release())
        controls: list[viser.GuiInputHandle[Any]] = [self._frame, *self._push]
        for control in controls:
            control.on_update(self._changed)

    def _add_forces(self, setup: Setup) -> None:
        rows = [
            f"{contact.name}/{label}"
            for contact in setup.contacts.contacts
            for label in contact.regulated
        ]
        if not rows:
            return
        with self._gui.add_folder("Wanted force, added to the scenario's [N]"):
            for row in rows:
                slider = self._gui.add_slider(row, -MOST_FORCE, MOST_FORCE, 0.5, 0.0)
                slider.on_update(self._changed)
                self._forces[row] = slider

    def _add_gains(self) -> None:
        with self._gui.add_folder("Gains", expand_by_default=False):
            self._damping = self._gui.add_slider("K_d, times", 0.1, 2.0, 0.05, 1.0)
            self._damping.on_update(self._changed)
            for name, unit in GAIN_UNITS.items():
                given = self._given[name]
                box = self._gui.add_number(f"{name} [{unit}]", given, min=0.0, step=step_of(given))
                box.on_update(self._changed)
                self._gains[name] = box

    def _release(self) -> None:
        for slider in self._push:
            write(slider, 0.0)
        self._send_request()

    def _changed(self, event: viser.GuiEvent[Any]) -> None:
        if event.client_id is not None:
            self._send_request()

    def _send_request(self) -> None:
        """Send what stands in the controls; one thread at a time, so that the newest is last."""
        with self._turn:
            request = self.request
            if request != self._told:
                self._told = request
                self._send("request", request)

    def _set_running(self, running: bool) -> None:
        self._running = running
        self._pause.label = "Pause" if running else "Go on"
        paused, going = viser.Icon.PLAYER_PLAY, viser.Icon.PLAYER_PAUSE
        self._pause.icon = going if running else paused


def step_of(value: float) -> float:
    """Return the power of ten at about a hundredth of `value`: a page drops finer decimals."""
    return 10.0 ** (np.floor(np.log10(value)) - 2.0) if value > 0.0 else 0.01
