"""Distances of pairs of bodies stay above a security distance: velocity damping."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from equipoise.distances import DistanceEvaluator, EndDistances
from equipoise.errors import InputError
from equipoise.hqp import Rows
from equipoise.kinematics import Kinematics
from equipoise.spatial import Array
from equipoise.tasks.base import Task
from equipoise.world import Pair, Scene

_ENDS_FROM = 0.4  # share of the influence distance below which the ends of capsules count too
_NEARLY_AS_NEAR = 0.01  # [m] an end further away than this beyond its pair cannot take its place


class AvoidanceTask(Task):
    """Damp the approach of each pair: `d/dt distance >= -damping (distance - d_s) / (d_i - d_s)`.

    The bound acts below the influence distance `d_i` [m]; the security distance `d_s` [m] is
    approached exponentially and not crossed while `damping * dt <= d_i - d_s`. `damping` [m/s] is
    the approach speed that is still allowed at `d_i`.
    Source: section V (Faverjon and Tournassoud 1987); a bound on velocity, not on displacement.
    """

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
        self.influence = influence
        self.security = security
        self.damping = damping
        self._distances = DistanceEvaluator(scene, pairs)
        self._ends = EndDistances(scene, pairs)
        self._row_labels = (*self.labels, *self._ends.labels)
        self._upper = np.full(len(self._row_labels), np.inf)

    @property
    def labels(self) -> tuple[str, ...]:
        """The names of the pairs."""
        return tuple(pair.name for pair in self.pairs)

    @property
    def units(self) -> tuple[str, ...]:
        """Metres."""
        return ("m",) * len(self.pairs)

    def rows(self, kin: Kinematics, t: float) -> Rows:
        """Return one lower-bounded row a pair, and one for each capsule end in it.

        Pairs beyond the influence distance are free.
        """
        count = len(self.pairs)
        A = np.zeros((len(self._row_labels), kin.robot.nv))
        lower = np.full(len(self._row_labels), -np.inf)
        distances = self._distances.at(kin)
        near = np.flatnonzero(distances < self.influence)
        if near.size:
            A[near] = self._distances.jacobian(kin, near)
            lower[near] = self._bound(distances[near])
            close = near[distances[near] < _ENDS_FROM * self.influence]
            within = distances[close] + _NEARLY_AS_NEAR
            ends, distances, rates = self._ends.near(kin, close, within)
            A[count + ends] = rates
            lower[count + ends] = self._bound(distances)
        return Rows(self.name, "m/s", self._row_labels, A, lower, self._upper)

    def _bound(self, distances: Array) -> Array:
        slope = self.damping / (self.influence - self.security)
        return -slope * (distances - self.security)

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return how far [m] each pair is below the security distance."""
        return np.maximum(0.0, self.security - self._distances.at(kin))
