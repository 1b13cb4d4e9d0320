"""What there is to draw of a scene: coloured triangles that move with the joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import coal
import numpy as np
import pinocchio as pin

from equipoise.analysis.rendering.looks.robot_looks import MOST_TRIANGLES, looks_of
from equipoise.analysis.rendering.looks.simplify import simplified
from equipoise.analysis.rendering.part import Part
from equipoise.analysis.rendering.stands import stands
from equipoise.analysis.rendering.tessellation import Mesh, tessellate
from equipoise.collision.scene import Scene
from equipoise.robots import Robot
from equipoise.robots.hulls import is_mesh
from equipoise.spatial import Array, Indices

_LENS_RADIUS = 0.03  # [m]
_LENS_RGB = (0.08, 0.09, 0.11)
_STICK_RADIUS = 0.012  # [m]
_STICK_RGB = (0.72, 0.74, 0.77)


@dataclass(frozen=True)
class Picture:
    """All triangles of a scene at one configuration; `part` (m,) tells whose each is."""

    mesh: Mesh
    part: Indices
    rgb: Array


class SceneMeshes:
    """The shapes of a scene, tessellated once: the robot's visual shapes and all world bodies.

    HRP-2 has shells of our own, other named robots the meshes beside their URDFs. A robot without
    visual shapes is drawn by its collision shapes, one without these by sticks from joint to joint.
    Where a robot of simple shapes has a camera, a dark ball stands for its lens, for the eye alone.
    Fixed bodies that would hang in the air stand on posts, but for those that are `moving`.
    """

    def __init__(self, scene: Scene, moving: frozenset[str] = frozenset()) -> None:
        self.model = scene.robot.model
        self._data = self.model.createData()
        self.parts = tuple([*robot_parts(scene.robot), *_world_parts(scene, moving)])
        self.moving = np.array([part.joint > 0 for part in self.parts])

    def at(self, q: Array) -> Picture:
        """Return the triangles in world coordinates at a configuration `q` (nq,)."""
        pin.forwardKinematics(self.model, self._data, np.array(q, dtype=float))
        placed = [(part.mesh.moved(self._data.oMi[part.joint]), part.rgb) for part in self.parts]
        return join_parts(placed)


def join_parts(placed: Sequence[tuple[Mesh, Array]]) -> Picture:
    """Return the picture of meshes in the world, each with its colour (3,)."""
    meshes = [mesh for mesh, _ in placed]
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    joined = Mesh(
        np.vstack([np.empty((0, 3)), *(mesh.vertices for mesh in meshes)]),
        np.vstack([np.empty((0, 3)), *(mesh.normals for mesh in meshes)]),
        np.vstack(
            [
                np.empty((0, 3), dtype=int),
                *(mesh.triangles + start for mesh, start in zip(meshes, starts, strict=False)),
            ]
        ),
    )
    part = np.repeat(np.arange(len(meshes)), [len(mesh.triangles) for mesh in meshes])
    return Picture(joined, part, np.array([rgb for _, rgb in placed]).reshape(-1, 3))


def robot_parts(robot: Robot) -> list[Part]:
    """Return what a robot looks like."""
    parts = looks_of(robot)
    if parts:
        return parts
    visual = list(robot.visual_model.geometryObjects)
    parts = shape_parts(visual) or collision_parts(robot) or _sticks(robot.model)
    lens = tessellate(coal.Sphere(_LENS_RADIUS))
    if robot.camera is not None and lens is not None:
        frame = robot.model.frames[robot.frame_id(robot.camera)]
        parts.append(Part(frame.parentJoint, lens.moved(frame.placement), np.array(_LENS_RGB)))
    return parts


def collision_parts(robot: Robot) -> list[Part]:
    """Return the shapes that a robot's distances are measured with."""
    return shape_parts(robot.collision_model.geometryObjects)


def _sticks(model: pin.Model) -> list[Part]:
    """Return a ball for each joint, and a stick to it from the joint before."""
    parts = []
    for joint in range(1, model.njoints):
        shapes = [(joint, coal.Sphere(1.5 * _STICK_RADIUS), pin.SE3.Identity())]
        way = model.jointPlacements[joint].translation
        length = float(np.linalg.norm(way))
        if length > _STICK_RADIUS:
            up = np.array([0.0, 0.0, 1.0])
            turn = pin.Quaternion.FromTwoVectors(up, way / length).toRotationMatrix()
            stick = coal.Capsule(_STICK_RADIUS, length)
            shapes.append((model.parents[joint], stick, pin.SE3(turn, 0.5 * way)))
        for carrier, shape, T in shapes:
            mesh = tessellate(shape)
            if mesh is not None:
                parts.append(Part(carrier, mesh.moved(T), np.array(_STICK_RGB)))
    return parts


def _world_parts(scene: Scene, moving: frozenset[str]) -> list[Part]:
    shapes = scene.geometry.geometryObjects
    seen = [shapes[i] for body in scene.bodies for i in scene.shapes_of(body.name)]
    return [*shape_parts(seen), *stands(scene, moving)]


def shape_parts(shapes: Sequence[pin.GeometryObject]) -> list[Part]:
    """Return the parts of shapes in the axes of their joints."""
    parts = []
    for shape, mesh in zip(shapes, _meshes(shapes), strict=True):
        if mesh is not None and len(mesh.triangles):
            rgb = np.clip(np.asarray(shape.meshColor, dtype=float)[:3], 0.0, 1.0)
            moved = mesh.moved(shape.placement)
            parts.append(Part(shape.parentJoint, moved, rgb, shape.geometry, shape.placement))
    return parts


def _meshes(shapes: Sequence[pin.GeometryObject]) -> list[Mesh | None]:
    """Return the triangles of each shape, fewer of what came from a file."""
    meshes = [tessellate(shape.geometry) for shape in shapes]
    detailed = [k for k, shape in enumerate(shapes) if is_mesh(shape.geometry)]
    given = [(m.vertices, m.triangles) for k in detailed if (m := meshes[k]) is not None]
    if sum(len(triangles) for _, triangles in given) > MOST_TRIANGLES:
        for k, mesh in zip(detailed, simplified(given, MOST_TRIANGLES), strict=True):
            meshes[k] = mesh
    return meshes
