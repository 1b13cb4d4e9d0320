"""Words for rows: how a person calls a row, its unit, and the rate that made an error a speed."""

from __future__ import annotations

import math
from dataclasses import dataclass

from equipoise.hqp.hierarchy import Hierarchy

SPEED_LIMIT = "the speed limit of"  # how a bound on a speed as such is called
_SCALES = {  # unit: (least value, factor, what it is then called), largest first
    "m": ((1.0, 1.0, "m"), (0.01, 100.0, "cm"), (0.0, 1000.0, "mm")),
    "rad": ((0.0, 180.0 / math.pi, "deg"),),
}


@dataclass(frozen=True, slots=True)
class RowDescription:
    """How a row is called: `above` where its upper bound is meant, `below` for its lower.

    `unit` of A v. `rate_above`, `rate_below` [1/s]: what an error was multiplied by to become the
    bound, so that a speed divided by it is an error again; NaN where there is no such rate.
    `weight`: A v and its bounds stand in the hierarchy so many times as large.
    """

    unit: str
    above: str
    below: str
    rate_above: float = math.nan
    rate_below: float = math.nan
    weight: float = 1.0

    @classmethod
    def both(cls, phrase: str, unit: str, rate: float = math.nan) -> RowDescription:
        """Return the words of a row whose two sides are called the same."""
        return cls(unit, phrase, phrase, rate, rate)

    def phrase(self, value: float) -> str:
        """Return the name of the side that a signed violation is on."""
        return self.above if value > 0.0 else self.below

    def is_speed(self, value: float) -> bool:
        """Return whether the side that a signed violation is on bounds a speed as such."""
        return self.phrase(value).startswith(SPEED_LIMIT)

    def rate(self, value: float) -> float:
        """Return the rate [1/s] of the side that a signed violation is on."""
        return self.rate_above if value > 0.0 else self.rate_below


def plain_descriptions(hierarchy: Hierarchy) -> tuple[RowDescription, ...]:
    """Return words made of the names in the hierarchy alone, one for each row [m]."""
    return tuple(
        RowDescription.both(f"{block.name}/{label}", block.unit)
        for block in hierarchy.blocks
        for label in block.labels
    )


def as_error(speed: float, unit: str, rate: float) -> tuple[float, str]:
    """Return the error that a speed belongs to, `speed / rate`, or the speed if there is none."""
    if unit.endswith("/s") and rate > 0.0:
        return speed / rate, unit.removesuffix("/s")
    return speed, unit


def quantity(value: float, unit: str) -> str:
    """Return a value >= 0 with two digits in a unit of handy size: 0.032 m is 3.2 cm."""
    base, per_second = unit.removesuffix("/s"), "/s" if unit.endswith("/s") else ""
    for least, factor, called in _SCALES.get(base, ((0.0, 1.0, base),)):
        if value >= least:
            return f"{_two_digits(value * factor)} {called}{per_second}".rstrip()
    return f"{_two_digits(value)} {unit}".rstrip()


def _two_digits(value: float) -> str:
    if not math.isfinite(value) or value == 0.0:
        return f"{value:.0f}"
    digits = max(0, 1 - math.floor(math.log10(abs(value))))
    return f"{value:.{digits}f}" if digits <= 4 else f"{value:.1e}"
