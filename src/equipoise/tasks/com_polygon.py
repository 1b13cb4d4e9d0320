"""Projection of the centre of mass stays inside the support polygon: one inequality an edge."""

from __future__ import annotations

import numpy as np

from equipoise.contacts import SupportPolygon
from equipoise.hqp import Rows
from equipoise.kinematics import Kinematics
from equipoise.spatial import Array
from equipoise.tasks.base import Task


class ComPolygonTask(Task):
    """Bound the speed of the centre of mass toward each edge by its distance to it.

    `n . J_com v <= rate * (distance to the edge - margin)`: the edge minus `margin` [m] is
    approached exponentially and not crossed while `rate * dt <= 1`; outside, it is returned to.
    Source: section V (Sugihara and Nakamura 2002 for the Jacobian).
    """

    def __init__(
        self, name: str, polygon: SupportPolygon, *, margin: float = 0.02, rate: float = 10.0
    ) -> None:
        super().__init__(name)
        self.polygon = polygon
        self.margin = margin
        self.rate = rate
        self._lower = np.full(len(polygon.offsets), -np.inf)

    @property
    def labels(self) -> tuple[str, ...]:
        """One edge a row."""
        return tuple(f"edge{i}" for i in range(len(self.polygon.offsets)))

    @property
    def units(self) -> tuple[str, ...]:
        """Metres."""
        return ("m",) * len(self.polygon.offsets)

    def rows(self, kin: Kinematics, t: float) -> Rows:
        """Return one upper-bounded row an edge."""
        A = self.polygon.normals @ kin.J_com[:2]
        upper = self.rate * (self._room(kin) - self.margin)
        return Rows(self.name, "m/s", self.labels, A, self._lower, upper)

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return how far [m] the centre of mass is beyond each edge moved in by the margin."""
        return np.maximum(0.0, self.margin - self._room(kin))

    def _room(self, kin: Kinematics) -> Array:
        return self.polygon.offsets - self.polygon.normals @ kin.p_world_com[:2]
