"""The rows of contacts at one state, written in place: what a stack asks its contacts to fill."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from equipoise.spatial import Array


@dataclass(frozen=True, slots=True)
class ContactRows:
    """`J` (r, nv), `rate` (r,), `residual` (r,) and `drift` (r,), as `Contact` defines them."""

    J: Array
    rate: Array
    residual: Array
    drift: Array

    @classmethod
    def of_size(cls, size: int, nv: int) -> ContactRows:
        """Return room for `size` rows."""
        return cls(np.zeros((size, nv)), np.zeros(size), np.zeros(size), np.zeros(size))
