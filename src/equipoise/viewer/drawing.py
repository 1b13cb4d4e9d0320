"""A robot and its world as meshes of a viser scene that follow the joints."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin
import viser

from equipoise.analysis.stage import Part, Stage
from equipoise.analysis.tessellation import tessellate
from equipoise.spatial import Array
from equipoise.viewer.showing import Showable
from equipoise.world import Scene

GHOST_RGB, GHOST_OPACITY = (60, 130, 255), 0.4
GHOST_INSET = 0.003  # [m] inwards, so that only what differs from the robot comes out of it
_STILL = 1e-7  # a joint that moved less is not sent again

Coloured = tuple[tuple[int, int, int], Array, Array]  # colour, vertices, triangles


class Drawing(Showable):
    """Parts under `root`, one node a joint (fewer nodes open a page sooner).

    `colour` replaces their own colours; `inset` [m] moves their surfaces inwards.
    """

    def __init__(
        self,
        scene: viser.SceneApi,
        root: str,
        parts: Sequence[Part],
        *,
        colour: tuple[int, int, int] | None = None,
        opacity: float | None = None,
        inset: float = 0.0,
    ) -> None:
        self._scene = scene
        self._top = scene.add_frame(root, show_axes=False)
        self._joints = sorted({part.joint for part in parts})
        self._nodes: dict[int, viser.SceneNodeHandle] = {}
        self._meshes: list[viser.MeshHandle] = []
        for joint in self._joints:
            mine = _by_colour([part for part in parts if part.joint == joint], colour)
            meshes = [(rgb, *_joined(same, inset)) for rgb, same in mine.items()]
            self._nodes[joint] = self._add_node(f"{root}/joint{joint}", meshes, opacity)
        self._sent: dict[int, Array] = {}

    def _add_node(
        self, name: str, meshes: Sequence[Coloured], opacity: float | None
    ) -> viser.SceneNodeHandle:
        """Add what moves with a joint: its mesh itself, or a frame where it has several."""
        scene, alone = self._scene, len(meshes) == 1
        node = None if alone else scene.add_frame(name, show_axes=False)
        for k, (rgb, vertices, triangles) in enumerate(meshes):
            own = name if alone else f"{name}/shape{k}"
            mesh = scene.add_mesh_simple(
                own, vertices, triangles, color=rgb, opacity=opacity, cast_shadow=False
            )
            self._meshes.append(mesh)
        return self._meshes[-1] if node is None else node

    def set_visible(self, visible: bool) -> None:
        """Show or hide everything."""
        self._top.visible = visible

    def set_opacity(self, opacity: float) -> None:
        """Make everything translucent; 1 is solid."""
        for mesh in self._meshes:
            mesh.opacity = None if opacity >= 1.0 else opacity

    def shift(self, offset: Array) -> None:
        """Move everything by `offset` (3,) [m], world axes."""
        self._top.position = offset

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


def body_parts(scene: Scene, name: str) -> list[Part]:
    """Return the meshes of a body of the world."""
    parts = []
    for index in scene.shapes_of(name):
        shape = scene.geometry.geometryObjects[index]
        mesh = tessellate(shape.geometry)
        if mesh is not None:
            rgb = np.clip(np.asarray(shape.meshColor, dtype=float)[:3], 0.0, 1.0)
            parts.append(Part(shape.parentJoint, mesh.moved(shape.placement), rgb))
    return parts


def _by_colour(
    parts: Sequence[Part], colour: tuple[int, int, int] | None
) -> dict[tuple[int, int, int], list[Part]]:
    groups: dict[tuple[int, int, int], list[Part]] = {}
    for part in parts:
        red, green, blue = (round(255 * float(c)) for c in part.rgb)
        groups.setdefault(colour or (red, green, blue), []).append(part)
    return groups


def _joined(parts: Sequence[Part], inset: float) -> tuple[Array, Array]:
    starts = np.cumsum([0, *(len(part.mesh.vertices) for part in parts)])
    vertices = np.vstack([p.mesh.vertices - inset * p.mesh.normals for p in parts])
    triangles = np.vstack(
        [part.mesh.triangles + start for part, start in zip(parts, starts, strict=False)]
    )
    return vertices, triangles
