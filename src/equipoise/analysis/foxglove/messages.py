"""Foxglove's public messages from ours: poses, colours, shapes, arrows, and times.

Source: the package foxglove-schemas-protobuf (MIT).
"""

from __future__ import annotations

from typing import Any

import coal
import numpy as np
import pinocchio as pin
from foxglove_schemas_protobuf.Color_pb2 import Color
from foxglove_schemas_protobuf.Pose_pb2 import Pose
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from google.protobuf.descriptor_pb2 import FileDescriptorSet

from equipoise.analysis.rendering.tessellation import Mesh
from equipoise.runlog.topics import Topic
from equipoise.spatial import Array

WORLD = "world"  # the frame that everything is placed in
SHAFT, HEAD, HEAD_LENGTH = 0.016, 0.04, 0.045  # [m] diameters of an arrow, length of its head


def topic(name: str, messages: list[tuple[int, Any]]) -> Topic:
    """Return a topic of messages of one class, each with its time [ns]."""
    kind = messages[0][1].DESCRIPTOR
    files = FileDescriptorSet()
    _add_file(kind.file, files, set())
    schema = files.SerializeToString(deterministic=True)
    octets = [(t, message.SerializeToString(deterministic=True)) for t, message in messages]
    return Topic(name, kind.full_name, schema, octets)


def _add_file(file: Any, files: FileDescriptorSet, seen: set[str]) -> None:
    """Add a file and, before it, those that it needs."""
    if file.name in seen:
        return
    seen.add(file.name)
    for other in file.dependencies:
        _add_file(other, files, seen)
    file.CopyToProto(files.file.add())


def stamp(message: Any, t: int) -> None:
    """Write a time [ns] into a message's timestamp."""
    message.timestamp.seconds, message.timestamp.nanos = divmod(t, 1_000_000_000)


def pose(T: pin.SE3) -> Pose:
    """Return a placement as a message."""
    return placed(Pose(), pin.SE3ToXYZQUAT(T))


def placed(message: Any, numbers: Array) -> Any:
    """Write x, y, z and a quaternion xyzw (7,) into a pose."""
    at, turn = message.position, message.orientation
    at.x, at.y, at.z = (float(x) for x in numbers[:3])
    turn.x, turn.y, turn.z, turn.w = (float(x) for x in numbers[3:])
    return message


def colour(rgb: Array, opacity: float = 1.0) -> Color:
    """Return a colour (3,) in 0..1 as a message."""
    red, green, blue = (float(c) for c in rgb)
    return Color(r=red, g=green, b=blue, a=opacity)


def add_shape(entity: SceneEntity, shape: coal.CollisionGeometry, T: pin.SE3, rgb: Array) -> bool:
    """Add a Coal shape as Foxglove's own; tell whether Foxglove has such a shape.

    A capsule becomes a cylinder and two balls.
    """
    if isinstance(shape, coal.Box):
        _size(entity.cubes.add(pose=pose(T), color=colour(rgb)), 2.0 * np.array(shape.halfSide))
    elif isinstance(shape, coal.Sphere):
        _ball(entity, shape.radius, T, rgb)
    elif isinstance(shape, coal.Cylinder):
        _cylinder(entity, shape.radius, 2.0 * shape.halfLength, T, rgb)
    elif isinstance(shape, coal.Capsule):
        _cylinder(entity, shape.radius, 2.0 * shape.halfLength, T, rgb)
        for side in (-1.0, 1.0):
            end = pin.SE3(np.eye(3), np.array([0.0, 0.0, side * shape.halfLength]))
            _ball(entity, shape.radius, T * end, rgb)
    else:
        return False
    return True


def _ball(entity: SceneEntity, radius: float, T: pin.SE3, rgb: Array) -> None:
    _size(entity.spheres.add(pose=pose(T), color=colour(rgb)), np.full(3, 2.0 * radius))


def _cylinder(entity: SceneEntity, radius: float, length: float, T: pin.SE3, rgb: Array) -> None:
    made = entity.cylinders.add(pose=pose(T), color=colour(rgb), bottom_scale=1.0, top_scale=1.0)
    _size(made, np.array([2.0 * radius, 2.0 * radius, length]))


def _size(message: Any, size: Array) -> None:
    message.size.x, message.size.y, message.size.z = (float(x) for x in size)


def add_mesh(entity: SceneEntity, mesh: Mesh, rgb: Array) -> None:
    """Add triangles; corners at one place are written once."""
    made = entity.triangles.add(pose=pose(pin.SE3.Identity()), color=colour(rgb))
    places, index = np.unique(np.round(mesh.vertices, 5), axis=0, return_inverse=True)
    for x, y, z in places.tolist():
        made.points.add(x=x, y=y, z=z)
    made.indices.extend(index.reshape(-1)[mesh.triangles].reshape(-1).tolist())


def add_arrow(entity: SceneEntity, arrow: Array, rgb: Array) -> None:
    """Add an arrow (2, 3) [m] from tail to tip; one without length is left out."""
    way = arrow[1] - arrow[0]
    length = float(np.linalg.norm(way))
    if length < 1e-4:
        return
    turn = pin.Quaternion.FromTwoVectors(np.array([1.0, 0.0, 0.0]), way / length)
    head = min(HEAD_LENGTH, length)
    made = entity.arrows.add(
        shaft_length=length - head,
        shaft_diameter=SHAFT,
        head_length=head,
        head_diameter=HEAD,
        color=colour(rgb),
    )
    placed(made.pose, np.array([*arrow[0], turn.x, turn.y, turn.z, turn.w]))
