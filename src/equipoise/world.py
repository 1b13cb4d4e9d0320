"""What surrounds the robot: boxes fixed in the world and objects held in a hand, and distances.

`Scene` joins them with the robot's collision shapes in one Coal geometry model.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from operator import attrgetter

import coal
import numpy as np
import pinocchio as pin

from equipoise.errors import InputError, NameNotFoundError
from equipoise.kinematics import Kinematics
from equipoise.robots import Robot
from equipoise.spatial import Array

_MIN_DISTANCE = attrgetter("min_distance")


@dataclass(frozen=True)
class Shape:
    """A box or an upright cylinder: `size` is (x, y, z) or (diameter, diameter, height) [m]."""

    kind: str
    size: tuple[float, float, float]
    T_body_shape: pin.SE3
    rgba: tuple[float, float, float, float] = (0.7, 0.6, 0.45, 1.0)

    def geometry(self) -> coal.CollisionGeometry:
        """Return the Coal shape."""
        if self.kind == "box":
            return coal.Box(*self.size)
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


@dataclass(frozen=True)
class PairDistance:
    """Distance [m] of a pair of shapes, its witness points and normal in world axes.

    The normal points from the first to the second shape, so the rate of `distance` is
    `normal . (velocity of the second point - velocity of the first)`. Negative: penetration.
    """

    distance: float
    p_world_first: Array
    p_world_second: Array
    normal: Array


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


class DistanceEvaluator:
    """Distances of chosen pairs of a scene, reusing Coal's buffers."""

    def __init__(self, scene: Scene, pairs: Sequence[Pair]) -> None:
        self.scene = scene
        self.pairs = tuple(pairs)
        self._geometry = scene.geometry.copy()
        self._geometry.removeAllCollisionPairs()
        self._bounds = [0]
        for pair in self.pairs:
            for i in scene.shapes_of(pair.first):
                for j in scene.shapes_of(pair.second):
                    self._geometry.addCollisionPair(pin.CollisionPair(i, j))
            self._bounds.append(len(self._geometry.collisionPairs))
        self._count = self._bounds[-1]
        self._starts = np.array(self._bounds[:-1], dtype=int)
        self._of_shapes = np.full(self._count, np.inf)
        self._geometry_data = self._geometry.createData()
        self._joint_ids = np.array([self._joints(pair) for pair in self.pairs], dtype=int)

    def _joints(self, pair: Pair) -> tuple[int, int]:
        objects = self.scene.geometry.geometryObjects
        first = objects[self.scene.shapes_of(pair.first)[0]].parentJoint
        second = objects[self.scene.shapes_of(pair.second)[0]].parentJoint
        return first, second

    def at(self, kin: Kinematics) -> Array:
        """Return the distance [m] (len(pairs),) of every pair at the state of `kin`."""
        if not self.pairs:
            return np.zeros(0)
        model, data = self.scene.robot.model, kin.pin_data
        pin.updateGeometryPlacements(model, data, self._geometry, self._geometry_data)
        pin.computeDistances(self._geometry, self._geometry_data)
        of_shapes = np.fromiter(
            map(_MIN_DISTANCE, self._geometry_data.distanceResults), float, self._count
        )
        distances = np.minimum.reduceat(of_shapes, self._starts)
        self._of_shapes = of_shapes
        return distances

    def witness(self, pair: int) -> PairDistance:
        """Return points and normal of a pair (its index) at the last state given to `at`."""
        start, stop = self._bounds[pair], self._bounds[pair + 1]
        nearest = start + int(np.argmin(self._of_shapes[start:stop]))
        result = self._geometry_data.distanceResults[nearest]
        return PairDistance(
            result.min_distance,
            result.getNearestPoint1(),
            result.getNearestPoint2(),
            result.normal,
        )

    def jacobian(self, kin: Kinematics, pairs: Array) -> Array:
        """Return rows (k, nv): rates of the distances of chosen pairs (indices) at that state."""
        found = [self.witness(pair) for pair in pairs]
        normals = np.array([w.normal for w in found])
        first = np.array([w.p_world_first for w in found])
        second = np.array([w.p_world_second for w in found])
        joints = self._joint_ids[pairs]
        rates = kin.point_speed_rows(joints[:, 1], second, normals)
        return rates - kin.point_speed_rows(joints[:, 0], first, normals)
