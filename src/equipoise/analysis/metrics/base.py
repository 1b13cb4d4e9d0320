"""What a metric is, and the small steps that many of them take."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from equipoise.analysis.run_context import RunContext
from equipoise.spatial import Array, Mask

POSITION, ANGLE = slice(0, 3), slice(3, 6)  # of a pose error


@dataclass(frozen=True)
class Metric:
    """A named number: its unit, what it says, and how it is computed (None: does not apply)."""

    name: str
    unit: str
    doc: str
    compute: Callable[[RunContext], float | None]


def largest(arrays: list[Array], keep: Mask) -> float | None:
    """Return the largest absolute value over the kept ticks; infinite if there is no such tick."""
    if not arrays:
        return None
    if not keep.any():
        return np.inf
    return max(float(np.abs(a[keep]).max()) for a in arrays)


def least(arrays: list[Array]) -> float | None:
    """Return the least value of all, None without arrays."""
    return min(float(a.min()) for a in arrays) if arrays else None


def lengths(errors: list[Array], part: slice) -> list[Array]:
    """Return the lengths (N,) of a part of errors (N, k)."""
    return [np.linalg.norm(e[:, part], axis=1) for e in errors]


def rms(values: Array) -> float:
    """Return the largest root of the mean square over the columns of (N, k); infinite if empty."""
    return float(np.sqrt((values**2).mean(axis=0)).max()) if len(values) else np.inf
