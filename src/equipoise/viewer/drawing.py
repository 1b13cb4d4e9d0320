"""A robot and its world as meshes of a viser scene that follow the joints."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin
import viser

from equipoise.analysis.rendering.part import Part
from equipoise.analysis.rendering.tessellation import tessellate
from equipoise.collision.scene import Scene
from equipoise.spatial import POSE_SIZE, Array, Indices
from equipoise.viewer.layer import Showable

_STILL = 1e-5  # [m, or of a quaternion] a joint that moved less is not sent again: 0.2 mm at a hand

Coloured = tuple[tuple[int, int, int], Array, Indices]  # colour, vertices, triangles


class Drawing(Showable):
    """Parts under `root`, one node a joint (fewer nodes open a page sooner).

    A node hangs on the node of the joint before it in `parents` (of the model), so that only
    what a joint itself turns by is sent. `colour` replaces the parts' own colours; `inset` [m]
    moves their surfaces inwards.
    """

    def __init__(
        self,
        scene: viser.SceneApi,
        root: str,
        parts: Sequence[Part],
        parents: Sequence[int] = (),
        *,
        colour: tuple[int, int, int] | None = None,
        opacity: float | None = None,
        inset: float = 0.0,
    ) -> None:
        self._scene = scene
        self._top = scene.add_frame(root, show_axes=False)
        self._visible, self._opacity = True, opacity
        self._above = _joints_above(sorted({part.joint for part in parts}), parents)
        self._nodes: dict[int, viser.SceneNodeHandle] = {}
        self._meshes: list[viser.MeshHandle] = []
        for joint, above in self._above.items():
            mine = _by_colour([part for part in parts if part.joint == joint], colour)
            meshes = [(rgb, *_joined(same, inset)) for rgb, same in mine.items()]
            parent = root if above is None else self._nodes[above].name
            self._nodes[joint] = self._add_node(f"{parent}/joint{joint}", meshes)
        self._sent: dict[int, Array] = {}

    @property
    def solid(self) -> bool:
        """Whether nothing inside it can be seen."""
        return self._visible and self._opacity is None

    def _add_node(self, name: str, meshes: Sequence[Coloured]) -> viser.SceneNodeHandle:
        """Add what moves with a joint: its mesh itself, or a frame where it has several."""
        scene, alone = self._scene, len(meshes) == 1
        node = None if alone else scene.add_frame(name, show_axes=False)
        for k, (rgb, vertices, triangles) in enumerate(meshes):
            own = name if alone else f"{name}/shape{k}"
            mesh = scene.add_mesh_simple(
                own, vertices, triangles, color=rgb, opacity=self._opacity, cast_shadow=False
            )
            self._meshes.append(mesh)
        return self._meshes[-1] if node is None else node

    def set_visible(self, visible: bool) -> None:
        """Show or hide everything."""
        self._visible = self._top.visible = visible

    def set_opacity(self, opacity: float) -> None:
        """Make everything translucent; 1 is solid."""
        self._opacity = None if opacity >= 1.0 else opacity
        for mesh in self._meshes:
            mesh.opacity = self._opacity

    def shift(self, offset: Array) -> None:
        """Move everything by `offset` (3,) [m], world axes."""
        self._top.position = offset

    def place(self, placements: Sequence[pin.SE3]) -> None:
        """Move every joint's node to its placement in the world."""
        for joint, above in self._above.items():
            T = placements[joint] if above is None else placements[above].actInv(placements[joint])
            pose, node = pin.SE3ToXYZQUAT(T), self._nodes[joint]
            sent = self._sent.setdefault(joint, np.full(POSE_SIZE, np.inf))
            if np.abs(pose[:3] - sent[:3]).max() > _STILL:
                node.position = sent[:3] = pose[:3]
            if np.abs(pose[3:] - sent[3:]).max() > _STILL:
                node.wxyz, sent[3:] = pose[[6, 3, 4, 5]], pose[3:]


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


def _joints_above(joints: Sequence[int], parents: Sequence[int]) -> dict[int, int | None]:
    """Return for each of the joints, which ascend, the next one below the base that is one."""
    above: dict[int, int | None] = {}
    for joint in joints:
        up = parents[joint] if joint < len(parents) and joint > 0 else None
        while up is not None and up not in above:
            up = parents[up] if up > 0 else None
        above[joint] = up
    return above


def _by_colour(
    parts: Sequence[Part], colour: tuple[int, int, int] | None
) -> dict[tuple[int, int, int], list[Part]]:
    groups: dict[tuple[int, int, int], list[Part]] = {}
    for part in parts:
        red, green, blue = (round(255 * float(c)) for c in part.rgb)
        groups.setdefault(colour or (red, green, blue), []).append(part)
    return groups


def _joined(parts: Sequence[Part], inset: float) -> tuple[Array, Indices]:
    starts = np.cumsum([0, *(len(part.mesh.vertices) for part in parts)])
    vertices = np.vstack([p.mesh.vertices - inset * p.mesh.normals for p in parts])
    triangles = np.vstack(
        [part.mesh.triangles + start for part, start in zip(parts, starts, strict=False)]
    )
    return vertices, triangles
