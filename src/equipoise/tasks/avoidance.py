"""Distances of pairs of bodies stay above a security distance: velocity damping."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from equipoise.collision.distances import DistanceEvaluator, EndDistances
from equipoise.collision.kernels import rate_of_distance
from equipoise.collision.scene import Pair, Scene
from equipoise.compiled.compilation import entrance
from equipoise.errors import InputError
from equipoise.kinematics import Kinematics
from equipoise.spatial import Array
from equipoise.tasks.base import CompiledTask

_ENDS_FROM = 0.4  # share of the influence distance below which the ends of capsules count too
_NEARLY_AS_NEAR = 0.01  # [m] an end further away than this beyond its pair cannot take its place


class AvoidanceTask(CompiledTask):
    """Damp the approach of each pair: `d/dt distance >= -damping (distance - d_s) / (d_i - d_s)`.

    The bound acts below the influence distance `d_i` [m]; the security distance `d_s` [m] is
    approached exponentially and not crossed while `damping * dt <= d_i - d_s`. `damping` [m/s] is
    the approach speed that is still allowed at `d_i`.
    Source: section V (Faverjon and Tournassoud 1987); a bound on velocity, not on displacement.
    """

    row_unit = "m/s"

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
        if not 0.0 <= security < influence:
            raise InputError(
                f"task {name!r} needs 0 <= security < influence", given=(security, influence)
            )
        self.pairs = tuple(pairs)
        self._labels = tuple(pair.name for pair in self.pairs)
        self.influence = influence
        self.security = security
        self.damping = damping
        self.influence, self.security = float(influence), float(security)
        self._distances = DistanceEvaluator(scene, pairs)
        self._ends = EndDistances(scene, pairs)
        self._close = np.zeros(len(self.pairs), dtype=np.int8)
        self._row_labels = (*self.labels, *self._ends.labels)

    @property
    def labels(self) -> tuple[str, ...]:
        """The names of the pairs."""
        return self._labels

    @property
    def units(self) -> tuple[str, ...]:
        """Metres."""
        return ("m",) * len(self.pairs)

    def row_labels(self, t: float) -> tuple[str, ...]:
        """Return a row a pair, and one for each capsule end in it."""
        return self._row_labels

    def fill(
        self, kin: Kinematics, t: float, A: Array, lower: Array, upper: Array, at: int
    ) -> None:
        """Write one lower-bounded row a pair and end; pairs beyond the influence are free."""
        live, found = kin.live, self._distances
        found.refresh(kin)
        slope = self.damping / (self.influence - self.security)
        last = at + len(self._row_labels)
        is_close = avoidance_rows(
            live.columns,
            live.carries,
            found.results,
            found.nearest,
            found.joint_ids,
            found.distances,
            self.influence,
            self.security,
            slope,
            _ENDS_FROM * self.influence,
            A,
            lower,
            upper,
            at,
            last,
            self._close,
        )
        if is_close:
            ends = self._ends
            ends.refresh(kin, self._close)
            end_rows(
                live.columns,
                live.carries,
                ends.results,
                ends.rows,
                ends.pair_of,
                ends.joint_ids,
                found.distances,
                self.security,
                slope,
                A,
                lower,
                at + len(self.pairs),
            )

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return how far [m] each pair is below the security distance."""
        return np.maximum(0.0, self.security - self._distances.at(kin))


@entrance
def avoidance_rows(
    columns: np.ndarray,
    carries: np.ndarray,
    results: np.ndarray,
    nearest: np.ndarray,
    joint_ids: np.ndarray,
    distances: np.ndarray,
    influence: float,
    security: float,
    slope: float,
    closeness: float,
    A: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    at: int,
    last: int,
    close: np.ndarray,
) -> bool:
    """Write the rows of the pairs, free ones up to `last`, and which pairs are close; any?

    `slope` [1/s] of the bound, `closeness` [m] the distance that is called close.
    """
    is_close = False
    for k in range(close.shape[0]):
        close[k] = 1 if distances[k] < closeness else 0
        is_close = is_close or close[k] == 1
    for i in range(at, last):
        lower[i], upper[i] = -np.inf, np.inf
        k = i - at
        if k < len(distances) and distances[k] < influence:
            first, second = joint_ids[k, 0], joint_ids[k, 1]
            rate_of_distance(columns, carries, results[nearest[k]], first, second, A, i)
            lower[i] = -slope * (distances[k] - security)
        else:
            for c in range(A.shape[1]):
                A[i, c] = 0.0
    return is_close


@entrance
def end_rows(
    columns: np.ndarray,
    carries: np.ndarray,
    results: np.ndarray,
    ends: np.ndarray,
    pair_of: np.ndarray,
    joint_ids: np.ndarray,
    distances: np.ndarray,
    security: float,
    slope: float,
    A: np.ndarray,
    lower: np.ndarray,
    at: int,
) -> None:
    """Write the rows of those `ends` [k] that are nearly as near as their pair's distance."""
    for k in range(ends.shape[0]):
        end = ends[k]
        distance = results[end, 0]
        if distance < distances[pair_of[k]] + _NEARLY_AS_NEAR:
            first, second = joint_ids[end, 0], joint_ids[end, 1]
            rate_of_distance(columns, carries, results[end], first, second, A, at + end)
            lower[at + end] = -slope * (distance - security)
