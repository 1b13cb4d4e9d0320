"""What surrounds the robot: bodies fixed in the world and objects held in a hand.

`Scene` joins them with the robot's collision shapes in one Coal geometry model.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import coal
import numpy as np
import pinocchio as pin

from equipoise.errors import InputError, NameNotFoundError
from equipoise.robots import Robot
from equipoise.robots.hulls import hull_of, is_mesh
from equipoise.spatial.numbers import real_array
from equipoise.spatial.poses import rigid

KINDS = ("box", "cylinder", "sphere")


@dataclass(frozen=True)
class Shape:
    """A box, an upright cylinder or a sphere; `size` [m] is that of the box around it.

    Raises: `InputError`.
    """

    kind: str
    size: tuple[float, float, float]
    T_body_shape: pin.SE3
    rgba: tuple[float, float, float, float] = (0.7, 0.6, 0.45, 1.0)

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise InputError("there is no such kind of shape", given=self.kind, known=KINDS)
        size = real_array(f"the size of a {self.kind}", self.size, (3,))
        if not (size > 0.0).all():
            raise InputError(
                f"the size of a {self.kind} must be positive [m]", given=tuple(size.tolist())
            )
        rigid(f"the place of a {self.kind}", self.T_body_shape)

    def geometry(self) -> coal.CollisionGeometry:
        """Return the Coal shape."""
        if self.kind == "box":
            return coal.Box(*self.size)
        if self.kind == "sphere":
            return coal.Sphere(self.size[0] / 2.0)
        return coal.Cylinder(self.size[0] / 2.0, self.size[2])


@dataclass(frozen=True)
class Body:
    """A rigid body of the world: fixed (`frame` None) or carried by a frame of the robot.

    `T_parent_body` is relative to the world or to that frame.
    """

    name: str
    shapes: tuple[Shape, ...]
    T_parent_body: pin.SE3
    frame: str | None = None

    def __post_init__(self) -> None:
        rigid(f"the pose of body {self.name!r}", self.T_parent_body)


@dataclass(frozen=True)
class Pair:
    """Two bodies by name; the distance of the pair is the least one over their shapes."""

    first: str
    second: str

    @property
    def name(self) -> str:
        """Return "first - second"."""
        return f"{self.first} - {self.second}"


class Scene:
    """The collision shapes of robot and world, by body name.

    A robot body is named by its link (all its shapes belong to it), a world body by its name.
    """

    def __init__(self, robot: Robot, bodies: Sequence[Body] = ()) -> None:
        self.robot = robot
        self.bodies = tuple(bodies)
        self.geometry = pin.GeometryModel()
        self._shapes: dict[str, list[int]] = {}
        for shape in robot.collision_model.geometryObjects:
            copy = shape.copy()
            if is_mesh(copy.geometry):
                copy.geometry = hull_of(copy).shape
            link = robot.model.frames[shape.parentFrame].name
            self._add(link, copy)
        for body in self.bodies:
            self._add_body(body)

    def _add(self, body: str, shape: pin.GeometryObject) -> None:
        index = self.geometry.addGeometryObject(shape)
        self._shapes.setdefault(body, []).append(index)

    def _add_body(self, body: Body) -> None:
        if body.name in self._shapes:
            raise InputError(
                "two bodies share a name", given=body.name, remedy="Rename the body of the world"
            )
        model = self.robot.model
        if body.frame is None:
            joint, frame_id, T_joint_frame = 0, 0, pin.SE3.Identity()
        else:
            frame_id = self.robot.frame_id(body.frame)
            joint = model.frames[frame_id].parentJoint
            T_joint_frame = model.frames[frame_id].placement
        for i, shape in enumerate(body.shapes):
            placement = T_joint_frame * body.T_parent_body * shape.T_body_shape
            geometry = pin.GeometryObject(
                f"{body.name}_{i}", joint, frame_id, placement, shape.geometry()
            )
            geometry.meshColor = np.array(shape.rgba)
            self._add(body.name, geometry)

    @property
    def body_names(self) -> tuple[str, ...]:
        """Names of all bodies that have a shape."""
        return tuple(self._shapes)

    def pair(self, first: str, second: str) -> Pair:
        """Return the pair of two bodies. Raises: `NameNotFoundError`."""
        for name in (first, second):
            if name not in self._shapes:
                raise NameNotFoundError("body with a collision shape", name, self._shapes)
        if first == second:
            raise InputError("a body keeps no distance to itself", given=first)
        return Pair(first, second)

    def shapes_of(self, body: str) -> tuple[int, ...]:
        """Return the indices in `geometry` of a body's shapes."""
        return tuple(self._shapes[body])
