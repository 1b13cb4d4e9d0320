"""What bisection found: by line and controller the last good share and the first that was not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from equipoise.spatial import Array, Mask
from equipoise.studies.draw import between, ends_of
from equipoise.studies.lines import Line, lines_of
from equipoise.studies.results import Results
from equipoise.studies.schema import BoundarySpec


@dataclass(frozen=True)
class Bracket:
    """On a line: good up to `low`, not good from `high` on, shares of its length.

    `low` is NaN if not even its begin was good, `high` if all of it was.
    """

    design: str
    point: int
    line: Line
    controller: str
    low: float
    high: float

    @property
    def middle(self) -> float:
        """The boundary as far as it is known: 0 before the line, 1 behind it."""
        if np.isnan(self.low):
            return 0.0
        return 1.0 if np.isnan(self.high) else 0.5 * (self.low + self.high)


def brackets(results: Results, design: str) -> list[Bracket]:
    """Return what is known of every line of a boundary; of several seeds the worst counts."""
    spec = results.study.designs[design]
    assert isinstance(spec, BoundarySpec)
    found = []
    for place, line in enumerate(lines_of(results.study.parameters, spec)):
        for controller in results.controllers:
            rows = results.where(design=design, point=place, controller=controller)
            shares, good = results["share"][rows], results["good"][rows].astype(bool)
            if len(shares):
                low, high = _bracket(shares, good)
                found.append(Bracket(design, place, line, controller, low, high))
    return found


def _bracket(shares: Array, good: Mask) -> tuple[float, float]:
    bad = shares[~good]
    high = float(bad.min()) if len(bad) else np.nan
    fine = shares[good & ~(shares >= high)]
    return (float(fine.max()) if len(fine) else np.nan), high


def value_on(results: Results, bracket: Bracket, share: float, parameter: str) -> float:
    """Return the value of a parameter at a share of a bracket's line."""
    spec = results.study.parameters[parameter]
    line = bracket.line
    if parameter in line.begin:
        return between(spec, line.begin[parameter], line.end[parameter], share)
    low, _ = ends_of(spec)
    return float(line.rest.get(parameter, low))


def survival(found: list[Bracket], scales: Array) -> tuple[Array, Array]:
    """Return which share of lines (k,) is still good at each scale (k,), at least and at most."""
    low = np.array([-1.0 if np.isnan(one.low) else one.low for one in found])
    high = np.array([np.inf if np.isnan(one.high) else one.high for one in found])
    whole = np.where(np.isinf(high), np.inf, low)  # good to the end: nothing is known behind it
    at_least = (whole[None, :] >= scales[:, None]).mean(axis=1)
    at_most = (high[None, :] > scales[:, None]).mean(axis=1)
    return at_least, at_most
