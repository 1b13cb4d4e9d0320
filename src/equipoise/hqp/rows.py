"""Rows: a named block of `lower <= A v <= upper`, the one form that every task takes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NoReturn

import numpy as np

from equipoise.errors import InputError, NonFiniteError, ShapeError
from equipoise.hqp.soundness import are_sound


@dataclass(frozen=True, slots=True)
class Rows:
    """A block of rows `lower <= A v <= upper`; a row is an equality where both bounds are equal.

    `name` (the task or contact), `unit` (of A v), `labels` (one a row), `A` [m, n],
    `lower` [m], `upper` [m]. One bound of a row may be infinite; with both infinite the row is
    free. The values are checked when the block is stacked into a `Hierarchy`, or by `check`.

    Raises:
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
        if self.A.ndim != 2 or self.A.shape[0] != m:
            raise ShapeError(f"A of rows {self.name!r}", self.A.shape, (m, "n"))
        if self.lower.shape != (m,):
            raise ShapeError(f"lower of rows {self.name!r}", self.lower.shape, (m,))
        if self.upper.shape != (m,):
            raise ShapeError(f"upper of rows {self.name!r}", self.upper.shape, (m,))

    def __len__(self) -> int:
        return len(self.labels)

    def check(self) -> None:
        """Refuse a NaN, an infinite coefficient, and a lower bound above its upper bound.

        Raises:
            NonFiniteError: names the block and the row.
            InputError: lower > upper; names the block and the row.
        """
        if not are_sound(self.A, self.lower, self.upper):
            self.refuse()

    def refuse(self) -> NoReturn:
        """Raise the error of the first unsound row, by name."""
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
        raise AssertionError("refuse() was called on rows that are sound")
