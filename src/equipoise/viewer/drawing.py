"""A robot and its world as meshes of a viser scene that follow the joints."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin
import viser

from equipoise.analysis.stage import Part, Stage
from equipoise.spatial import Array
from equipoise.viewer.showing import Showable
from equipoise.world import Scene

GHOST_RGB, GHOST_OPACITY = (90, 160, 255), 0.3
_STILL = 1e-7  # a joint that moved less is not sent again


class Drawing(Showable):
    """Parts under `root`, one node a joint; `colour` replaces their own colours."""

    def __init__(
        self,
        scene: viser.SceneApi,
        root: str,
        parts: Sequence[Part],
        *,
        colour: tuple[int, int, int] | None = None,
        opacity: float | None = None,
    ) -> None:
        self._scene = scene
        self._top = scene.add_frame(root, show_axes=False)
        self._joints = sorted({part.joint for part in parts})
        self._nodes = {
            joint: scene.add_frame(f"{root}/joint{joint}", show_axes=False)
            for joint in self._joints
        }
        self._meshes = []
        for joint in self._joints:
            mine = [part for part in parts if part.joint == joint]
            for k, (rgb, same) in enumerate(_by_colour(mine, colour).items()):
                vertices, triangles = _joined(same)
                name = f"{root}/joint{joint}/shape{k}"
                mesh = scene.add_mesh_simple(
                    name, vertices, triangles, color=rgb, opacity=opacity, cast_shadow=False
                )
                self._meshes.append(mesh)
        self._sent: dict[int, Array] = {}

    def set_visible(self, visible: bool) -> None:
        """Show or hide everything."""
        self._top.visible = visible

    def set_opacity(self, opacity: float) -> None:
        """Make everything translucent; 1 is solid."""
        for mesh in self._meshes:
            mesh.opacity = None if opacity >= 1.0 else opacity

    def place(self, placements: Sequence[pin.SE3]) -> None:
        """Move every joint's node to its placement in the world."""
        for joint in self._joints:
            pose = pin.SE3ToXYZQUAT(placements[joint])
            before = self._sent.get(joint)
            if before is not None and np.abs(pose - before).max() < _STILL:
                continue
            self._sent[joint] = pose
            node = self._nodes[joint]
            node.position = pose[:3]
            node.wxyz = pose[[6, 3, 4, 5]]


def robot_parts(scene: Scene) -> tuple[Part, ...]:
    """Return the meshes of the robot alone."""
    return Stage(Scene(scene.robot)).parts


def world_parts(scene: Scene) -> tuple[Part, ...]:
    """Return the meshes of everything but the robot."""
    return Stage(scene).parts[len(robot_parts(scene)) :]


def _by_colour(
    parts: Sequence[Part], colour: tuple[int, int, int] | None
) -> dict[tuple[int, int, int], list[Part]]:
    groups: dict[tuple[int, int, int], list[Part]] = {}
    for part in parts:
        red, green, blue = (round(255 * float(c)) for c in part.rgb)
        groups.setdefault(colour or (red, green, blue), []).append(part)
    return groups


def _joined(parts: Sequence[Part]) -> tuple[Array, Array]:
    starts = np.cumsum([0, *(len(part.mesh.vertices) for part in parts)])
    vertices = np.vstack([part.mesh.vertices for part in parts])
    triangles = np.vstack(
        [part.mesh.triangles + start for part, start in zip(parts, starts, strict=False)]
    )
    return vertices, triangles
