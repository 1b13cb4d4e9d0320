"""The soles of a walk as outlines, coloured by the phase of each."""

from __future__ import annotations

import numpy as np
import viser

from equipoise.analysis.feet_phases import PHASE
from equipoise.contacts import Phase
from equipoise.contacts.support_polygon import sole_corners
from equipoise.simulation.build.setup import Setup
from equipoise.viewer.layer import Layer, Moment
from equipoise.walking import Feet

COLOURS = {
    Phase.HELD: (0, 140, 90),
    Phase.FREE: (150, 150, 150),
    Phase.TOUCHED: (255, 150, 0),
    Phase.LATE: (214, 40, 40),
    Phase.LOST: (200, 0, 160),
}
OUTLINE = [0, 1, 2, 3, 0]  # corners of a sole, around
LIFT = 0.004  # [m] over the ground, so that lines on it are not swallowed


class FeetLayer(Layer):
    """Nothing of a robot that stands; of one that walks an outline a sole."""

    title = "Phases of the feet"

    def __init__(self, scene: viser.SceneApi, setup: Setup) -> None:
        self._soles = () if setup.carrier is None else Feet.of(setup.robot).soles
        self._lines = scene.add_line_segments(
            "/feet", np.zeros((0, 2, 3)), np.zeros((0, 2, 3)), thickness=0.008
        )

    def set_visible(self, visible: bool) -> None:
        self._lines.visible = visible

    def show(self, moment: Moment) -> None:
        codes = moment.values.get(PHASE)
        if codes is None or not self._soles:
            return
        edges, colours = [], []
        for sole, code in zip(self._soles, codes, strict=True):
            corners = sole_corners(sole, moment.kin.placement(sole.frame))[OUTLINE]
            corners[:, 2] += LIFT
            edges.append(np.stack([corners[:-1], corners[1:]], axis=1))
            phase = next((one for one in Phase if one.code == code), Phase.FREE)
            colours.append(np.full((4, 2, 3), COLOURS[phase]))
        self._lines.colors = np.concatenate(colours).astype(np.uint8)
        self._lines.points = np.concatenate(edges).astype(np.float32)
