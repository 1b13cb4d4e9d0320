"""Rows: a named block of `lower <= A v <= upper`, the one form that every task takes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NoReturn

import numpy as np

from equipoise.errors import InputError, NonFiniteError, ShapeError
from equipoise.hqp.soundness import (
    LARGEST_BOUND,
    LARGEST_ROW,
    LENGTHS_APART,
    SMALLEST_ROW,
    are_sound,
)

REAL = "fiu"  # kinds of dtype


@dataclass(frozen=True, slots=True)
class Rows:
    """A block of rows `lower <= A v <= upper`; a row is an equality where both bounds are equal.

    `name` (the task or contact), `unit` (of A v), `labels` (one a row), `A` [m, n],
    `lower` [m], `upper` [m]. One bound of a row may be infinite; with both infinite the row is
    free. The values are checked when the block is stacked into a `Hierarchy`, or by `check`.

    Raises:
        InputError: A or a bound is no array of real numbers.
        ShapeError: an array does not fit `labels`.
    """

    name: str
    unit: str
    labels: tuple[str, ...]
    A: np.ndarray
    lower: np.ndarray
    upper: np.ndarray

    def __post_init__(self) -> None:
        m = len(self.labels)
        for what in ("A", "lower", "upper"):
            array = getattr(self, what)
            if not isinstance(array, np.ndarray) or array.dtype.kind not in REAL:
                raise InputError(
                    f"{what} of rows {self.name!r} must be a NumPy array of real numbers",
                    given=getattr(array, "dtype", type(array).__name__),
                    remedy="Make it one with np.asarray(..., dtype=float)",
                )
        if self.A.ndim != 2 or self.A.shape[0] != m:
            raise ShapeError(f"A of rows {self.name!r}", self.A.shape, (m, "n"))
        if self.lower.shape != (m,):
            raise ShapeError(f"lower of rows {self.name!r}", self.lower.shape, (m,))
        if self.upper.shape != (m,):
            raise ShapeError(f"upper of rows {self.name!r}", self.upper.shape, (m,))

    def __len__(self) -> int:
        return len(self.labels)

    def check(self) -> None:
        """Refuse what no solver should see, as in a level of its own.

        Raises:
            NonFiniteError: a NaN, or an infinite coefficient; names the block and the row.
            InputError: lower > upper, a number out of range, or rows whose lengths are too far
                apart; names the block and the row.
        """
        A, lower, upper = (np.array(x, dtype=float) for x in (self.A, self.lower, self.upper))
        if not are_sound(A, lower, upper, np.array([len(self)])):
            self.refuse()
            names = [f"row {label!r} of rows {self.name!r}" for label in self.labels]
            refuse_lengths(A, lower, upper, names)

    def refuse(self) -> None:
        """Raise the error of the first row that is unsound by itself, by name."""
        for r, label in enumerate(self.labels):
            place = f"row {label!r} of rows {self.name!r}"
            lower, upper = self.lower[r], self.upper[r]
            if not np.isfinite(self.A[r]).all():
                raise NonFiniteError(
                    f"A coefficient of {place} is not finite",
                    given=self.A[r].tolist(),
                    remedy="Look at the Jacobian that the row was made from",
                )
            if np.isnan(lower) or np.isnan(upper):
                raise NonFiniteError(
                    f"A bound of {place} is not a number",
                    given=(float(lower), float(upper)),
                    remedy="Look at the target and at the measured state",
                )
            if lower > upper:
                raise InputError(
                    f"The lower bound of {place} is above its upper bound [{self.unit}]",
                    given=(float(lower), float(upper)),
                    remedy="Give lower <= upper; equal bounds make an equality",
                )
            if lower == np.inf or upper == -np.inf:
                raise NonFiniteError(
                    f"No number meets the bounds of {place}",
                    given=(float(lower), float(upper)),
                    remedy="Use -inf below and +inf above for a side without a bound",
                )
            length, largest = np.linalg.norm(self.A[r]), np.abs(self.A[r]).max(initial=0.0)
            if largest > 0.0 and not SMALLEST_ROW <= length <= LARGEST_ROW:
                raise InputError(
                    f"The coefficients of {place} are out of range",
                    given=float(largest),
                    remedy=f"Give a row of a length from {SMALLEST_ROW:g} to {LARGEST_ROW:g}",
                )
            if any(LARGEST_BOUND < abs(bound) < np.inf for bound in (lower, upper)):
                raise InputError(
                    f"A bound of {place} is out of range [{self.unit}]",
                    given=(float(lower), float(upper)),
                    remedy="Use -inf below and +inf above for a side without a bound",
                )


def refuse_lengths(
    A: np.ndarray, lower: np.ndarray, upper: np.ndarray, names: Sequence[str]
) -> NoReturn:
    """Raise the error of a level [m] whose rows have lengths too far apart."""
    lengths = np.linalg.norm(A, axis=1)
    lengths[(lengths == 0.0) | (np.isinf(lower) & np.isinf(upper))] = np.nan
    short, long = int(np.nanargmin(lengths)), int(np.nanargmax(lengths))
    raise InputError(
        f"The {names[short]} is {lengths[long] / lengths[short]:.1e} times shorter than the "
        f"{names[long]} in the same level, and would leave no digits in their sum of squares",
        given=(float(lengths[short]), float(lengths[long])),
        remedy=f"Scale its row and bounds, or give it a level of its own; up to {LENGTHS_APART:g} "
        "is allowed",
    )
