"""Distances between bodies of a scene, and how fast they change with the robot's velocity."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from operator import attrgetter

import coal
import numpy as np
import pinocchio as pin

from equipoise.kinematics import Kinematics
from equipoise.spatial import Array
from equipoise.world import Pair, Scene

_MIN_DISTANCE = attrgetter("min_distance")


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
        return _witness(self._geometry_data.distanceResults[nearest])

    def jacobian(self, kin: Kinematics, pairs: Array) -> Array:
        """Return rows (k, nv): rates of the distances of chosen pairs (indices) at that state."""
        return _rates(kin, [self.witness(pair) for pair in pairs], self._joint_ids[pairs])


class EndDistances:
    """Distances of the round ends of capsules, for pairs that are already near.

    The point of a capsule that is nearest to a flat face jumps from one end to the other when the
    capsule turns past parallel, and with it the row of the pair. With a row for each end beside
    the row of the whole, the set of allowed velocities stays continuous there.
    """

    def __init__(self, scene: Scene, pairs: Sequence[Pair]) -> None:
        self.scene = scene
        self._geometry = scene.geometry.copy()
        self._geometry.removeAllCollisionPairs()
        self._ends: dict[int, tuple[int, int]] = {}
        self.labels: list[str] = []
        self._rows_of: list[list[int]] = [[] for _ in pairs]
        self._joints: list[tuple[int, int]] = []
        for k, pair in enumerate(pairs):
            first, second = scene.shapes_of(pair.first), scene.shapes_of(pair.second)
            self._add_rows(k, pair, first, second)
            self._add_rows(k, pair, second, first)
        self._data = self._geometry.createData()
        self._joint_ids = np.array(self._joints, dtype=int).reshape(-1, 2)

    def _add_rows(self, k: int, pair: Pair, ended: Sequence[int], others: Sequence[int]) -> None:
        shapes = self.scene.geometry.geometryObjects
        for i in ended:
            if not isinstance(shapes[i].geometry, coal.Capsule):
                continue
            for number, end in enumerate(self._ends_of(i)):
                for j in others:
                    self._geometry.addCollisionPair(pin.CollisionPair(end, j))
                    self._rows_of[k].append(len(self._joints))
                    self._joints.append((shapes[i].parentJoint, shapes[j].parentJoint))
                    self.labels.append(
                        f"{pair.name} ({shapes[i].name} end {number}, {shapes[j].name})"
                    )

    def _ends_of(self, index: int) -> tuple[int, int]:
        if index not in self._ends:
            capsule = self.scene.geometry.geometryObjects[index]
            ends = []
            for sign in (-1.0, 1.0):
                T_capsule_end = pin.SE3(
                    np.eye(3), np.array([0, 0, sign * capsule.geometry.halfLength])
                )
                ends.append(
                    self._geometry.addGeometryObject(
                        pin.GeometryObject(
                            f"{capsule.name}_end{sign:+.0f}",
                            capsule.parentJoint,
                            capsule.parentFrame,
                            capsule.placement * T_capsule_end,
                            coal.Sphere(capsule.geometry.radius),
                        )
                    )
                )
            self._ends[index] = (ends[0], ends[1])
        return self._ends[index]

    def near(self, kin: Kinematics, pairs: Array, within: Array) -> tuple[Array, Array, Array]:
        """Return the ends of `pairs` (indices) that are nearer than `within` (len(pairs),) [m].

        Returns: rows (k,), their distances [m] (k,) and the rates of those (k, nv) at `kin`.
        """
        model, data = self.scene.robot.model, kin.pin_data
        pin.updateGeometryPlacements(model, data, self._geometry, self._data)
        geometry, results = self._geometry, self._data.distanceResults
        rows, found = [], []
        for pair, limit in zip(pairs.tolist(), within.tolist(), strict=True):
            for row in self._rows_of[pair]:
                pin.computeDistance(geometry, self._data, row)
                if results[row].min_distance < limit:
                    rows.append(row)
                    found.append(_witness(results[row]))
        kept = np.array(rows, dtype=int)
        distances = np.array([w.distance for w in found])
        return kept, distances, _rates(kin, found, self._joint_ids[kept])


def _witness(result: coal.DistanceResult) -> PairDistance:
    return PairDistance(
        result.min_distance,
        result.getNearestPoint1(),
        result.getNearestPoint2(),
        result.normal,
    )


def _rates(kin: Kinematics, found: Sequence[PairDistance], joint_ids: Array) -> Array:
    """Return rows (k, nv): rates of the distances of the witnesses on bodies of `joint_ids`."""
    if not found:
        return np.zeros((0, kin.robot.nv))
    normals = np.array([w.normal for w in found])
    first = np.array([w.p_world_first for w in found])
    second = np.array([w.p_world_second for w in found])
    rates = kin.point_speed_rows(joint_ids[:, 1], second, normals)
    return rates - kin.point_speed_rows(joint_ids[:, 0], first, normals)
