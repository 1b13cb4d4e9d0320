"""The world around the robot: fixed bodies, held objects, and sliders that have been pushed."""

from __future__ import annotations

import numpy as np
import viser

from equipoise.analysis.rendering.stands import stands
from equipoise.scenarios import schema
from equipoise.simulation.build.setup import Setup
from equipoise.viewer.drawing import Drawing, body_parts
from equipoise.viewer.layer import Layer, Moment


class Surroundings(Layer):
    """All bodies of the world; a slider stands where the log says that it was pushed to."""

    title = "World"

    def __init__(self, scene: viser.SceneApi, scenario: schema.Scenario, setup: Setup) -> None:
        self._bodies = {
            body.name: Drawing(scene, f"/world/{body.name}", body_parts(setup.scene, body.name))
            for body in setup.scene.bodies
        }
        posts = stands(setup.scene, frozenset(setup.sliders))
        if posts:
            self._bodies[""] = Drawing(scene, "/stands", posts)
        self._directions = {
            name: np.array(slider.direction) for name, slider in scenario.world.sliders.items()
        }

    def set_visible(self, visible: bool) -> None:
        for body in self._bodies.values():
            body.set_visible(visible)

    def show(self, moment: Moment) -> None:
        for body in self._bodies.values():
            body.place(moment.kin.pin_data.oMi)
        for name, direction in self._directions.items():
            travel = moment.values.get(f"slider/{name}")
            if travel is not None and np.isfinite(travel[0]):
                self._bodies[name].shift(travel[0] * direction)
