"""The trails of the hands: where the palms have been up to the moment that is shown."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import viser

from equipoise.kinematics import Kinematics, KinematicsEvaluator
from equipoise.simulation.build.setup import Setup
from equipoise.spatial import Array
from equipoise.viewer.layer import Layer, Moment

COLOUR = (120, 60, 200)


class TrailLayer(Layer):
    """Lines through the palms' places; pieces of the path may come in any order.

    `gather` and `publish` belong to one thread, `show` and `add` to another.
    """

    title = "Trails of the hands"

    def __init__(self, scene: viser.SceneApi, setup: Setup) -> None:
        robot = setup.robot
        self._evaluator = KinematicsEvaluator(robot)
        self._still = np.zeros(robot.nv)
        self._frames = [robot.frame_id(palm.frame) for palm in robot.palms]
        self._lines = scene.add_line_segments(
            "/trails", np.zeros((0, 2, 3)), COLOUR, thickness=0.004
        )
        self._gathered: dict[float, Array] = {}
        self._path = (np.zeros(0), np.zeros((0, len(self._frames), 3)))
        self._drawn = -1

    def gather(self, arrays: Mapping[str, Array], most: int) -> None:
        """Take at most `most` moments of a piece of the log: arrays by channel and "t"."""
        t, q = arrays["t"], arrays["q"]
        for k in range(0, len(t), max(1, -(-len(t) // most))):
            if np.isfinite(q[k]).all():
                kin = self._evaluator.at(q[k], self._still)
                self._gathered[float(t[k])] = self._palms(kin)

    def publish(self) -> None:
        """Show what was gathered from now on."""
        t = np.array(sorted(self._gathered))
        points = [self._gathered[moment] for moment in t]
        self._path = (t, np.array(points).reshape(len(points), -1, 3))
        self._drawn = -1

    def add(self, moment: Moment) -> None:
        """Lengthen the path by a moment of a run that is still going on."""
        t, points = self._path
        if not len(t) or moment.t > t[-1]:
            here = self._palms(moment.kin)[None]
            self._path = (np.append(t, moment.t), np.concatenate([points, here]))

    def set_visible(self, visible: bool) -> None:
        self._lines.visible = visible

    def show(self, moment: Moment) -> None:
        t, points = self._path
        upto = int(np.searchsorted(t, moment.t, side="right"))
        if upto == self._drawn:
            return
        self._drawn = upto
        path = points[:upto]
        segments = np.stack([path[:-1], path[1:]], axis=2).reshape(-1, 2, 3)
        self._lines.points = segments.astype(np.float32)

    def _palms(self, kin: Kinematics) -> Array:
        points = [kin.placement(frame).translation for frame in self._frames]
        return np.array(points).reshape(-1, 3)
