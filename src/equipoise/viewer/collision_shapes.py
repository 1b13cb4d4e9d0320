"""The shapes that distances are measured with, over the robot; sent once somebody asks for them."""

from __future__ import annotations

from collections.abc import Sequence

import pinocchio as pin
import viser

from equipoise.analysis.rendering.scene_meshes import collision_parts
from equipoise.robots import Robot
from equipoise.viewer.drawing import Drawing
from equipoise.viewer.layer import Showable

RGB, OPACITY = (20, 150, 90), 0.45


class CollisionShapes(Showable):
    """The robot's collision shapes, translucent; hidden at first."""

    def __init__(self, scene: viser.SceneApi, robot: Robot) -> None:
        self._scene, self._robot = scene, robot
        self._drawing: Drawing | None = None
        self._placements: Sequence[pin.SE3] | None = None

    def set_visible(self, visible: bool) -> None:
        """Show or hide them."""
        if visible and self._drawing is None:
            self._drawing = Drawing(
                self._scene,
                "/collision_shapes",
                collision_parts(self._robot),
                self._robot.model.parents,
                colour=RGB,
                opacity=OPACITY,
            )
        if self._drawing is not None:
            if self._placements is not None:
                self._drawing.place(self._placements)
            self._drawing.set_visible(visible)

    def place(self, placements: Sequence[pin.SE3]) -> None:
        """Move them with the joints."""
        self._placements = placements
        if self._drawing is not None:
            self._drawing.place(placements)
