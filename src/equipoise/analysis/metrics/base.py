"""What a metric is, and the small steps that many of them take."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from equipoise.analysis.run_context import RunContext
from equipoise.spatial import Array, Mask

POSITION, ANGLE = slice(0, 3), slice(3, 6)  # of a pose error


@dataclass(frozen=True, eq=False)
class Found:
    """A value with its place: `series` (N,) over the ticks, and `names` (N,) of whose it is."""

    value: float
    series: Array | None = None
    names: Sequence[str] = ()


@dataclass(frozen=True)
class Metric:
    """A named number: its unit, what it says, and how it is computed (None: does not apply)."""

    name: str
    unit: str
    doc: str
    compute: Callable[[RunContext], float | Found | None]


def largest(arrays: list[Array], keep: Mask) -> float | None:
    """Return the largest absolute value over the kept ticks; infinite if there is no such tick."""
    if not arrays:
        return None
    if not keep.any():
        return np.inf
    return float(np.max([np.abs(a[keep]).max() for a in arrays]))


def least(columns: Sequence[Array], names: Sequence[str]) -> Found | None:
    """Return the least of columns (N,) with the name of each, None without any; NaN counts."""
    return _extreme(np.column_stack(columns), names, np.argmin) if columns else None


def most(columns: Sequence[Array], names: Sequence[str]) -> Found | None:
    """Return the most of columns (N,) with the name of each, None without any; NaN counts."""
    return _extreme(np.column_stack(columns), names, np.argmax) if columns else None


def _extreme(table: Array, names: Sequence[str], choose: Callable[..., Array]) -> Found:
    which = choose(table, axis=1)  # numpy takes a NaN for both the least and the most
    series = table[np.arange(len(table)), which]
    return Found(float(series[choose(series)]), series, [names[k] for k in which])


def lengths(errors: list[Array], part: slice) -> list[Array]:
    """Return the lengths (N,) of a part of errors (N, k)."""
    return [np.linalg.norm(e[:, part], axis=1) for e in errors]


def rms(values: Array) -> float:
    """Return the largest root of the mean square over the columns of (N, k); infinite if empty."""
    return float(np.sqrt((values**2).mean(axis=0)).max()) if len(values) else np.inf
