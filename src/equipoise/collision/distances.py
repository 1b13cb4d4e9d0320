"""Distances between bodies of a scene at one state, and where they are nearest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from equipoise.collision.pairs import (
    FIND,
    NORMAL,
    ON_FIRST,
    ON_SECOND,
    PairProgram,
    find_distances_there,
    least_of_pairs,
)
from equipoise.collision.scene import Pair, Scene
from equipoise.compiled import entrance
from equipoise.compiled.workspace import Workspace, part_of
from equipoise.kinematics import Kinematics
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


@entrance
def find_alone(floats: np.ndarray, whole: np.ndarray, tables: np.ndarray) -> None:
    """Find the distances of the pairs in part 2 at the state in part 1."""
    find_distances_there(part_of(floats, whole, tables, 1), part_of(floats, whole, tables, 2), 0)


@entrance
def least_alone(floats: np.ndarray, whole: np.ndarray, tables: np.ndarray) -> None:
    """Find out which shapes of each pair are nearest."""
    least_of_pairs(part_of(floats, whole, tables, 2))


class DistanceEvaluator:
    """Distances of chosen pairs of a scene, in memory that the next state reuses."""

    def __init__(self, scene: Scene, pairs: Sequence[Pair]) -> None:
        self.scene, self.pairs = scene, tuple(pairs)
        self._program = PairProgram(scene, pairs)
        small = scene.robot.at(scene.robot.q_half_sitting).with_frames(())
        self._workspace = Workspace(
            {
                "tree": small.shapes_of("tree"),
                "state": small.shapes_of("state"),
                "pairs": self._program.array_shapes(),
            },
            stages=[FIND],
        )
        self._program.fill(self._workspace.pairs)
        self._blocks = (
            self._workspace.floats, self._workspace.integers, self._workspace.tables
        )  # fmt: skip

    def at(self, kin: Kinematics) -> Array:
        """Return the distance [m] (len(pairs),) of every pair at the state of `kin`."""
        if not self.pairs:
            return np.zeros(0)
        part = self._workspace.pairs
        self._workspace.take(kin.with_frames(()))
        find_alone(*self._blocks)
        if part.asked[0]:
            self._program.ask_coal(part)
        least_alone(*self._blocks)
        distances: Array = part.distance.copy()
        return distances

    def witness(self, pair: int) -> PairDistance:
        """Return points and normal of a pair (its index) at the last state given to `at`."""
        part = self._workspace.pairs
        row = part.found[part.nearest[pair]].copy()
        return PairDistance(
            float(row[0]), row[ON_FIRST:ON_SECOND], row[ON_SECOND:], row[NORMAL:ON_FIRST]
        )
