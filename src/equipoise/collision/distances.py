"""Distances between bodies of a scene, and how fast they change with the robot's velocity."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import coal
import numpy as np
import pinocchio as pin

from equipoise.collision.kernels import least_of_pairs, rates_of_distances
from equipoise.collision.scene import Pair, Scene
from equipoise.kinematics import Kinematics
from equipoise.kinematics.live_views import distance_rows
from equipoise.spatial import Array


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
        self._starts = np.array(self._bounds, dtype=np.int64)
        self._geometry_data = self._geometry.createData()
        self._results = _live_results(scene, self._geometry, self._geometry_data)
        self.nearest = np.zeros(len(self.pairs), dtype=np.int64)
        self.distances = np.zeros(len(self.pairs))
        self.joint_ids = np.array([self._joints(p) for p in self.pairs], dtype=np.int64)
        self.joint_ids = self.joint_ids.reshape(-1, 2)

    @property
    def results(self) -> Array:
        """Distance, normal and nearest points of each pair of shapes, see `distance_rows`."""
        return self._results

    def _joints(self, pair: Pair) -> tuple[int, int]:
        objects = self.scene.geometry.geometryObjects
        first = objects[self.scene.shapes_of(pair.first)[0]].parentJoint
        second = objects[self.scene.shapes_of(pair.second)[0]].parentJoint
        return first, second

    def at(self, kin: Kinematics) -> Array:
        """Return the distance [m] (len(pairs),) of every pair at the state of `kin`."""
        if not self.pairs:
            return np.zeros(0)
        self.refresh(kin)
        return self.distances.copy()

    def refresh(self, kin: Kinematics) -> None:
        """Write `distances` [m] of the pairs and the `nearest` shapes of each at that state."""
        if not self.pairs:
            return
        model, data = self.scene.robot.model, kin.pin_data
        pin.updateGeometryPlacements(model, data, self._geometry, self._geometry_data)
        pin.computeDistances(self._geometry, self._geometry_data)
        least_of_pairs(self._results, self._starts, self.distances, self.nearest)

    def witness(self, pair: int) -> PairDistance:
        """Return points and normal of a pair (its index) at the last state given to `at`."""
        row = self._results[self.nearest[pair]].copy()
        return PairDistance(float(row[0]), row[4:7], row[7:], row[1:4])

    def jacobian(self, kin: Kinematics, pairs: Array) -> Array:
        """Return rows (k, nv): rates of the distances of chosen pairs (indices) at that state."""
        live = kin.live
        A = np.zeros((len(pairs), kin.robot.nv))
        chosen = np.asarray(pairs, dtype=np.int64)
        rates_of_distances(
            live.columns,
            live.carries,
            self._results,
            self.nearest[chosen],
            self.joint_ids[chosen],
            A,
            0,
        )
        return A


class EndDistances:
    """Distances of the round ends of capsules, for pairs that are already near.

    The point of a capsule that is nearest to a flat face jumps from one end to the other when the
    capsule turns past parallel, and with it the row of the pair. With a row for each end beside
    the row of the whole, the set of allowed velocities stays continuous there.

    After `refresh` the ends at hand are those numbered `rows` (k,), of the pairs `pair_of` (k,).
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
        self.results = _live_results(scene, self._geometry, self._data)
        self.joint_ids = np.array(self._joints, dtype=np.int64).reshape(-1, 2)
        self._choose(b"", np.zeros(0, dtype=np.int64))

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

    def refresh(self, kin: Kinematics, close: Array) -> None:
        """Let Coal write `results` of the ends of `close` pairs (len(pairs),) of zeros and ones."""
        chosen = close.tobytes()
        if chosen != self._chosen:
            self._choose(chosen, np.flatnonzero(close))
        pin.updateGeometryPlacements(
            self.scene.robot.model, kin.pin_data, self._geometry, self._data
        )
        pin.computeDistances(self._geometry, self._data)

    def _choose(self, chosen: bytes, pairs: Array) -> None:
        """Let Coal look at the ends of these pairs only, until others are chosen."""
        self._chosen = chosen
        owners = [(row, pair) for pair in pairs for row in self._rows_of[pair]]
        self.rows = np.array([row for row, _ in owners], dtype=np.int64)
        self.pair_of = np.array([pair for _, pair in owners], dtype=np.int64)
        self._data.deactivateAllCollisionPairs()
        for row, _ in owners:
            self._data.activateCollisionPair(row)


def _live_results(
    scene: Scene, geometry: pin.GeometryModel, geometry_data: pin.GeometryData
) -> Array:
    """Return the live view of Coal's results, once they hold real numbers to check it with."""
    model = scene.robot.model
    data = model.createData()
    pin.forwardKinematics(model, data, scene.robot.q_half_sitting)
    pin.updateGeometryPlacements(model, data, geometry, geometry_data)
    pin.computeDistances(geometry, geometry_data)
    return distance_rows(geometry_data.distanceResults)
