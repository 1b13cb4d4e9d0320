"""The layers over the robot that say how it stands: balance, closest distances."""

from __future__ import annotations

import numpy as np
import viser

from equipoise.analysis.rendering.sole_arrows import pressure_in_sole, sole_contacts
from equipoise.collision.distances import DistanceEvaluator
from equipoise.collision.scene import Pair
from equipoise.simulation.build.setup import Setup
from equipoise.spatial import Array
from equipoise.viewer.layer import Layer, Moment

COM, PRESSURE, POLYGON = (30, 30, 30), (214, 40, 40), (0, 140, 90)
NEAR, FAR = np.array([214, 40, 40]), np.array([60, 160, 60])
LIFT = 0.003  # [m] over the floor, so that lines on it are not swallowed
NEAREST_PAIRS = 5


class BalanceLayer(Layer):
    """Support polygon, centre of mass with its projection, and centre of pressure."""

    title = "Balance (polygon, CoM, CoP)"

    def __init__(self, scene: viser.SceneApi, setup: Setup) -> None:
        self._setup = setup
        corners = np.zeros((1, 2)) if setup.polygon is None else setup.polygon.vertices
        floor = np.column_stack([corners, np.full(len(corners), LIFT)])
        edges = np.stack([floor, np.roll(floor, -1, axis=0)], axis=1)
        self._nodes = [
            scene.add_line_segments("/balance/polygon", edges, POLYGON, thickness=0.006),
            _ball(scene, "/balance/com", 0.03, COM),
            _ball(scene, "/balance/com_on_floor", 0.014, COM),
            _ball(scene, "/balance/cop", 0.014, PRESSURE),
        ]
        self._plumb = scene.add_line_segments(
            "/balance/plumb", np.zeros((1, 2, 3)), COM, thickness=0.003
        )

    def set_visible(self, visible: bool) -> None:
        for node in (*self._nodes, self._plumb):
            node.visible = visible

    def show(self, moment: Moment) -> None:
        com = moment.kin.p_world_com
        foot = np.array([com[0], com[1], LIFT])
        self._nodes[1].position, self._nodes[2].position = com, foot
        self._plumb.points = np.array([[com, foot]], dtype=np.float32)
        pressure = centre_of_pressure(self._setup, moment)
        if pressure is not None:
            self._nodes[3].position = pressure + np.array([0.0, 0.0, LIFT])


class DistanceLayer(Layer):
    """The closest monitored pairs as lines between their nearest points, red when near."""

    title = "Closest distances"

    def __init__(self, scene: viser.SceneApi, setup: Setup, pairs: list[Pair]) -> None:
        self._distances = DistanceEvaluator(setup.scene, pairs)
        self._lines = scene.add_line_segments(
            "/distances", np.zeros((0, 2, 3)), np.zeros((0, 2, 3)), thickness=0.005
        )
        self._visible = True

    def set_visible(self, visible: bool) -> None:
        self._visible = self._lines.visible = visible

    def show(self, moment: Moment) -> None:
        if not self._visible or not self._distances.pairs:
            return
        distances = self._distances.at(moment.kin)
        nearest = np.argsort(distances)[:NEAREST_PAIRS]
        found = [self._distances.witness(int(i)) for i in nearest]
        near = np.clip(distances[nearest] / 0.1, 0.0, 1.0)[:, None]
        colours = ((1.0 - near) * NEAR + near * FAR).astype(np.uint8)
        points = [[w.p_world_first, w.p_world_second] for w in found]
        self._lines.colors = np.repeat(colours[:, None], 2, axis=1)
        self._lines.points = np.array(points, dtype=np.float32)


def centre_of_pressure(setup: Setup, moment: Moment) -> Array | None:
    """Return the centre of pressure of all soles (3,) [m], world axes; None without a load.

    It is the mean of the soles' own centres, weighted by their normal forces.
    """
    total, weighted = 0.0, np.zeros(3)
    for contact in sole_contacts(setup):
        lam = moment.values.get(f"lam/{contact.name}")
        if lam is not None and lam[2] > 0.0:
            total += lam[2]
            T = moment.kin.placement(contact.sole.frame)
            weighted += lam[2] * T.act(pressure_in_sole(lam))
    return weighted / total if total > 0.0 else None


def _ball(
    scene: viser.SceneApi, name: str, radius: float, colour: tuple[int, int, int]
) -> viser.IcosphereHandle:
    return scene.add_icosphere(name, radius, colour, cast_shadow=False)
