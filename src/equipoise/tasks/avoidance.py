"""Distances of pairs of bodies stay above a security distance: velocity damping."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from equipoise.collision.distances import DistanceEvaluator, find_alone
from equipoise.collision.pairs import (
    DISTANCE,
    FIND,
    FOUND,
    KNOWN,
    NEAREST,
    PAIR_OF,
    STATE,
    WHOLE,
    PairProgram,
    distance_row,
    least_of_pairs,
)
from equipoise.collision.scene import Pair, Scene
from equipoise.compiled import compiled, entrance
from equipoise.compiled.workspace import Block, Part, Workspace, integers, matrix, part_of, vector
from equipoise.errors import InputError
from equipoise.hqp import Block as RowBlock
from equipoise.hqp import Hierarchy, RowDescription, Rows
from equipoise.kinematics import Kinematics
from equipoise.spatial import Array
from equipoise.tasks.base import Task
from equipoise.tasks.view import AVOIDANCE

ENDS_FROM = 0.4  # share of the influence distance below which the ends of capsules count too
_NEARLY_AS_NEAR = 0.01  # [m] an end further away than this beyond its pair cannot take its place


@compiled
def avoidance_rows(
    tree: Block, state: Block, pairs: Block, numbers: np.ndarray, A: np.ndarray, lower: np.ndarray,
    upper: np.ndarray, at: int,
) -> None:  # fmt: skip
    """Write a row a pair, and one an end that is nearly as near; others are free.

    `numbers` are influence and security distance [m] and the slope [1/s] of the bound.
    """
    influence, security, slope = numbers[0], numbers[1], numbers[2]
    least_of_pairs(pairs)
    distance, nearest, found = (
        vector(pairs, DISTANCE),
        integers(pairs, NEAREST),
        matrix(pairs, FOUND),
    )
    count = distance.shape[0]
    for k in range(count):
        lower[at + k], upper[at + k] = -np.inf, np.inf
        if distance[k] < influence:
            distance_row(tree, state, pairs, nearest[k], A, at + k)
            lower[at + k] = -slope * (distance[k] - security)
    known, whole, pair_of = integers(pairs, STATE), integers(pairs, WHOLE), integers(pairs, PAIR_OF)
    at += count
    for n in range(known.shape[0]):
        if whole[n] == n:
            continue
        lower[at], upper[at] = -np.inf, np.inf
        if known[n] == KNOWN and found[n, 0] < distance[pair_of[n]] + _NEARLY_AS_NEAR:
            distance_row(tree, state, pairs, n, A, at)
            lower[at] = -slope * (found[n, 0] - security)
        at += 1


@entrance
def rows_alone(
    floats: np.ndarray, whole: np.ndarray, tables: np.ndarray, numbers: np.ndarray, A: np.ndarray,
    lower: np.ndarray, upper: np.ndarray,
) -> None:  # fmt: skip
    """Write the rows of the pairs in part 2, whose distances are found."""
    tree, state = part_of(floats, whole, tables, 0), part_of(floats, whole, tables, 1)
    pairs = part_of(floats, whole, tables, 2)
    avoidance_rows(tree, state, pairs, numbers, A, lower, upper, 0)


class AvoidanceTask(Task):
    """Damp the approach of each pair: `d/dt distance >= -damping (distance - d_s) / (d_i - d_s)`.

    The bound acts below the influence distance `d_i` [m]; the security distance `d_s` [m] is
    approached exponentially and not crossed while `damping * dt <= d_i - d_s`. `damping` [m/s] is
    the approach speed that is still allowed at `d_i`.
    Source: section V (Faverjon and Tournassoud 1987); a bound on velocity, not on displacement.
    """

    row_unit = "m/s"
    kind = AVOIDANCE

    def __init__(
        self,
        name: str,
        scene: Scene,
        pairs: Sequence[Pair],
        *,
        influence: float = 0.10,
        security: float = 0.02,
        damping: float = 0.5,
    ) -> None:
        super().__init__(name)
        if not 0.0 <= security < influence or not np.isfinite(influence):
            raise InputError(
                f"task {name!r} needs 0 <= security < influence", given=(security, influence)
            )
        if not (np.isfinite(damping) and damping > 0.0):
            raise InputError(f"the damping of task {name!r} must be positive", given=damping)
        self.scene, self.pairs = scene, tuple(pairs)
        self.influence, self.security = float(influence), float(security)
        self.damping = float(damping)
        self.program = PairProgram(scene, pairs, ends=True)

    @property
    def labels(self) -> tuple[str, ...]:
        """The names of the pairs."""
        return tuple(pair.name for pair in self.pairs)

    @property
    def units(self) -> tuple[str, ...]:
        """Metres."""
        return ("m",) * len(self.pairs)

    @cached_property
    def row_labels(self) -> tuple[str, ...]:
        """A row a pair, and one for each capsule end in it."""
        return (*self.labels, *self.program.end_labels())

    @property
    def slope(self) -> float:
        """The slope [1/s] of the bound over the distance."""
        return self.damping / (self.influence - self.security)

    @property
    def fastest_rate(self) -> float:
        """The slope [1/s]: the rate with which the security distance is approached."""
        return self.slope

    @property
    def numbers(self) -> Array:
        """Influence and security distance [m], slope [1/s] (3,)."""
        return np.array([self.influence, self.security, self.slope])

    def fill(self, part: Part) -> None:
        """Write the constants of the pairs."""
        self.program.fill(part, self.influence, ENDS_FROM * self.influence)

    def rows(self, kin: Kinematics, t: float) -> Rows:
        """Return the rows at the state of `kin`; pairs beyond the influence are free."""
        m, small = len(self.row_labels), kin.with_frames(())
        A, lower, upper = np.zeros((m, kin.robot.nv)), np.empty(m), np.empty(m)
        workspace = Workspace(
            {
                "tree": small.shapes_of("tree"),
                "state": small.shapes_of("state"),
                "pairs": self.program.array_shapes(),
            },
            stages=[FIND],
        )
        workspace.take(small)
        self.fill(workspace.pairs)
        blocks = workspace.floats, workspace.integers, workspace.tables
        find_alone(*blocks)
        self.program.ask_coal(workspace.pairs)
        rows_alone(*blocks, self.numbers, A, lower, upper)
        return Rows(self.name, self.row_unit, self.row_labels, A, lower, upper)

    @cached_property
    def _distances(self) -> DistanceEvaluator:
        return DistanceEvaluator(self.scene, self.pairs)

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return how far [m] each pair is below the security distance."""
        return np.maximum(0.0, self.security - self._distances.at(kin))

    def describe(self, block: RowBlock, hierarchy: Hierarchy) -> tuple[RowDescription, ...]:
        """Return what a person calls each row; those of ends are named "first - second (...)"."""
        return tuple(
            RowDescription.both(f"the distance {label.split(' (')[0]}", "m/s", self.slope)
            for label in block.labels
        )
