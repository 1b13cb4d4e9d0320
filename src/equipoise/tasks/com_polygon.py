"""Projection of the centre of mass stays inside the support polygon: one inequality an edge."""

from __future__ import annotations

import numpy as np

from equipoise.compilation import entrance
from equipoise.contacts import SupportPolygon
from equipoise.kinematics import Kinematics
from equipoise.spatial import Array
from equipoise.tasks.base import CompiledTask


class ComPolygonTask(CompiledTask):
    """Bound the speed of the centre of mass toward each edge by its distance to it.

    `n . J_com v <= rate * (distance to the edge - margin)`: the edge minus `margin` [m] is
    approached exponentially and not crossed while `rate * dt <= 1`; outside, it is returned to.
    Source: section V (Sugihara and Nakamura 2002 for the Jacobian).
    """

    row_unit = "m/s"

    def __init__(
        self, name: str, polygon: SupportPolygon, *, margin: float = 0.02, rate: float = 10.0
    ) -> None:
        super().__init__(name)
        self.polygon = polygon
        self.margin = margin
        self.rate = rate
        self._labels = tuple(f"edge{i}" for i in range(len(polygon.offsets)))

    @property
    def labels(self) -> tuple[str, ...]:
        """One edge a row."""
        return self._labels

    @property
    def units(self) -> tuple[str, ...]:
        """Metres."""
        return ("m",) * len(self.polygon.offsets)

    def fill(
        self, kin: Kinematics, t: float, A: Array, lower: Array, upper: Array, at: int
    ) -> None:
        """Write one upper-bounded row an edge."""
        live, edges = kin.live_with_com, self.polygon
        com_rows(
            live.com,
            live.com_rows,
            edges.normals,
            edges.offsets,
            self.margin,
            self.rate,
            A,
            lower,
            upper,
            at,
        )

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return how far [m] the centre of mass is beyond each edge moved in by the margin."""
        return np.maximum(0.0, self.margin - self._room(kin))

    def _room(self, kin: Kinematics) -> Array:
        return self.polygon.offsets - self.polygon.normals @ kin.p_world_com[:2]


@entrance
def com_rows(
    com: np.ndarray,
    J_com: np.ndarray,
    normals: np.ndarray,
    offsets: np.ndarray,
    margin: float,
    rate: float,
    A: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    at: int,
) -> None:
    """Write `n . J_com v <= rate * (offset - n . com - margin)` for each edge."""
    for i in range(len(offsets)):
        nx, ny = normals[i, 0], normals[i, 1]
        for c in range(J_com.shape[1]):
            A[at + i, c] = nx * J_com[0, c] + ny * J_com[1, c]
        lower[at + i] = -np.inf
        upper[at + i] = rate * (offsets[i] - nx * com[0] - ny * com[1] - margin)
