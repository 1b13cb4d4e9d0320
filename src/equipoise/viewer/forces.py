"""The arrows: forces of the contacts on the robot, wanted ones beside them, and pushes."""

from __future__ import annotations

import numpy as np
import viser

from equipoise.analysis.rendering.force_arrows import ForceArrows, ending
from equipoise.scenarios import schema
from equipoise.simulation.build.setup import Setup
from equipoise.spatial import Array
from equipoise.viewer.layer import Layer, Moment

MEASURED, WANTED, PUSH = (214, 40, 40), (255, 170, 0), (200, 0, 160)
PUSH_SCALE = 1e-2  # [m/N]


class ForceLayer(Layer):
    """Contact forces on the robot as arrows to scale, wanted ones beside them where they exist."""

    title = "Contact forces"

    def __init__(self, scene: viser.SceneApi, setup: Setup) -> None:
        self._forces = ForceArrows(setup)
        self._measured = add_arrows(scene, "/forces/measured", MEASURED)
        self._wanted = add_arrows(scene, "/forces/wanted", WANTED)

    def set_visible(self, visible: bool) -> None:
        self._measured.visible = self._wanted.visible = visible

    def show(self, moment: Moment) -> None:
        arrows = self._forces.at(moment.kin, moment.values)
        draw_arrows(self._measured, arrows.measured)
        draw_arrows(self._wanted, arrows.wanted)


class PushLayer(Layer):
    """Pushes of a person and of the scenario as arrows that end where they act."""

    title = "Pushes"

    def __init__(self, scene: viser.SceneApi, scenario: schema.Scenario, setup: Setup) -> None:
        self._planned = [
            (setup.robot.frame_id(push.frame), push) for push in scenario.faults.pushes
        ]
        self._handle = add_arrows(scene, "/pushes", PUSH)

    def set_visible(self, visible: bool) -> None:
        self._handle.visible = visible

    def show(self, moment: Moment) -> None:
        pushes = [
            (moment.kin.placement(frame).translation, np.array(push.force))
            for frame, push in self._planned
            if push.start <= moment.t < push.start + push.duration
        ]
        force, point = moment.values.get("push"), moment.values.get("push_point")
        if force is not None and point is not None and np.isfinite(point).all():
            pushes.append((point, force))
        draw_arrows(self._handle, [ending(p, PUSH_SCALE * f) for p, f in pushes if f.any()])


def add_arrows(
    scene: viser.SceneApi, name: str, colour: tuple[int, int, int]
) -> viser.ArrowsHandle:
    """Add arrows that are not there yet."""
    return scene.add_arrows(
        name,
        np.zeros((1, 2, 3)),
        colour,
        shaft_radius=0.008,
        head_radius=0.02,
        head_length=0.045,
    )


def draw_arrows(handle: viser.ArrowsHandle, arrows: list[Array]) -> None:
    """Let arrows (2, 3) [m], from where to where, stand there, and no others."""
    handle.points = np.array(arrows or np.zeros((0, 2, 3)), dtype=np.float32)
