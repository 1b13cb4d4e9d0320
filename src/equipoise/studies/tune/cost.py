"""What a set of runs costs: one number for how far from their targets, and whether they stand."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import log
from statistics import median

from equipoise.studies.journal import Result

LEAST = 1e-9  # of a metric, so that its logarithm exists


@dataclass(frozen=True)
class Score:
    """`cost` (lower is better) of `of` runs, and how many of them stand and are good."""

    cost: float
    stands: int
    good: int
    of: int

    def __str__(self) -> str:
        return f"cost {self.cost:.2f}, {self.stands} of {self.of} stand, {self.good} good"


@dataclass(frozen=True)
class Cost:
    """Weights of metrics, what each is divided by, and what a fall costs."""

    weights: Mapping[str, float]
    scales: Mapping[str, float]
    fall: float
    duration: float

    @classmethod
    def over(
        cls, results: Sequence[Result], weights: Mapping[str, float], fall: float, duration: float
    ) -> Cost:
        """Return the cost in which the medians of these runs count zero."""
        scales = {}
        for name in weights:
            values = [one["row"]["metrics"].get(name) for one in results if one["row"]["stands"]]
            known = [value for value in values if value is not None and value > 0.0]
            scales[name] = median(known) if known else 1.0
        return cls(weights, scales, fall, duration)

    def of_run(self, result: Result) -> float:
        """Return what one run costs."""
        row = result["row"]
        if not row["stands"]:
            return self.fall + 1.0 - min(row["t_end"] / self.duration, 1.0)
        total = 0.0
        for name, weight in self.weights.items():
            value = row["metrics"].get(name)
            if value is None or value != value:
                return self.fall
            total += weight * log(max(value, LEAST) / self.scales[name])
        return min(total, self.fall)

    def score(self, results: Sequence[Result]) -> Score:
        """Return the mean cost of runs."""
        rows = [one["row"] for one in results]
        return Score(
            sum(map(self.of_run, results)) / len(results),
            sum(bool(row["stands"]) for row in rows),
            sum(bool(row["good"]) for row in rows),
            len(rows),
        )
