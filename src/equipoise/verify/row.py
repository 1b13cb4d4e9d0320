"""A row of the table: an equation or claim, how it is measured, and what came out."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

if TYPE_CHECKING:
    from equipoise.verify.evidence import Evidence


@dataclass(frozen=True)
class Measured:
    """What a check measured: a `residual` in the unit of its check, and a sentence about it."""

    residual: float
    note: str = ""


@dataclass(frozen=True)
class Check:
    """An equation ("(12)") or claim, what is checked, where it is in the code, and how.

    It holds if the residual is at most `tolerance` [unit; "" where it is relative].
    """

    key: str
    claim: str
    code: str
    tolerance: float
    unit: str
    measure: Callable[[Evidence], Measured]

    def judge(self, evidence: Evidence) -> Verdict:
        """Measure; whatever goes wrong meanwhile makes the row fail and is said in its note."""
        began = perf_counter()
        try:
            measured = self.measure(evidence)
        except Exception as error:  # a broken equation may break anything
            measured = Measured(np.inf, f"{type(error).__name__}: {error}")
        return Verdict(self, measured, perf_counter() - began)


@dataclass(frozen=True)
class Verdict:
    """A check with what it measured; `seconds` [s] is what it took."""

    check: Check
    measured: Measured
    seconds: float

    @property
    def holds(self) -> bool:
        """Whether the residual is a number at or below the tolerance."""
        residual = self.measured.residual
        return bool(np.isfinite(residual) and residual <= self.check.tolerance)

    def as_dict(self) -> dict[str, object]:
        """Return the row as plain values, for JSON (an infinite residual becomes None)."""
        residual = float(self.measured.residual)
        return {
            "key": self.check.key,
            "claim": self.check.claim,
            "code": self.check.code,
            "residual": residual if np.isfinite(residual) else None,
            "tolerance": self.check.tolerance,
            "unit": self.check.unit,
            "holds": self.holds,
            "note": self.measured.note,
            "seconds": round(self.seconds, 3),
        }


def worst(values: Iterable[ArrayLike]) -> float:
    """Return the largest absolute value of any nested arrays; infinite if one is not finite."""
    numbers = np.concatenate([np.ravel(np.asarray(value, dtype=float)) for value in values])
    return float(np.abs(numbers).max()) if np.isfinite(numbers).all() else np.inf
