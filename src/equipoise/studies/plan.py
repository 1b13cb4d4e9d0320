"""Which runs a study consists of: all that are known at the start, and those that follow from them.

What is to be run next depends on nothing but results, never on the order in which they come: that
is why any number of workers, with any interruption, ends with the same runs.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import product
from typing import Any

from equipoise.studies.draw import Values, points_of
from equipoise.studies.lines import Line, lines_of
from equipoise.studies.schema import BoundarySpec, StudySpec

LOW, HIGH = 0, 1  # the first two steps of a boundary: both ends


@dataclass(frozen=True, order=True)
class RunId:
    """Which run of a study: the order of these is the order of its results.

    `point` counts the points (or lines) of a design, `contender` the controllers, `repeat` the
    seeds; `step` counts the runs on a line, 0 for a single point.
    """

    design: str
    point: int
    contender: int
    repeat: int
    step: int = 0

    def __str__(self) -> str:
        return f"{self.design}/{self.point}/{self.contender}/{self.repeat}/{self.step}"

    @classmethod
    def read(cls, text: str) -> RunId:
        """Return what `str` of it was."""
        design, *numbers = text.split("/")
        return cls(design, *map(int, numbers))


@dataclass(frozen=True)
class StudyRun:
    """A run to be done: who runs, with which values of the parameters; `share` of which line."""

    id: RunId
    controller: str
    values: Values
    line: str = ""
    share: float = 1.0


@dataclass
class _Search:
    """A boundary being bisected: good at `low`, not good at `high`, both shares of the line."""

    line: Line
    low: float = 0.0
    high: float = 1.0
    done: bool = False
    runs: dict[int, float] = field(default_factory=dict)  # step -> share


class Plan:
    """The runs of a study: `first`, then `after` each result the ones that it makes known."""

    def __init__(self, study: StudySpec) -> None:
        self.study = study
        self.contenders = list(study.controllers)
        self._searches: dict[RunId, _Search] = {}
        self._spared = 0
        self._bisected = {
            name: lines_of(study.parameters, design)
            for name, design in study.designs.items()
            if isinstance(design, BoundarySpec)
        }
        self._points = {
            name: points_of(study.parameters, design)
            for name, design in study.designs.items()
            if not isinstance(design, BoundarySpec)
        }

    @property
    def most(self) -> int:
        """How many runs there are at most, as far as is known: boundaries may need fewer."""
        each = len(self.contenders) * self.study.seeds
        points = sum(map(len, self._points.values()))
        for name, lines in self._bisected.items():
            points += len(lines) * (2 + self._steps(name))
        return each * points - self._spared

    def first(self) -> Iterator[StudyRun]:
        """Yield the runs that need no result, the points interleaved so that all stay paired."""
        for name, points in self._points.items():
            for place, values in enumerate(points):
                for contender, repeat in self._each():
                    run_id = RunId(name, place, contender, repeat)
                    yield StudyRun(run_id, self.contenders[contender], values)
        for name, lines in self._bisected.items():
            for place, line in enumerate(lines):
                for contender, repeat in self._each():
                    chain = RunId(name, place, contender, repeat)
                    self._searches[chain] = _Search(line)
                    yield self._on_line(chain, LOW, 0.0)

    def after(self, run: RunId, *, good: bool) -> StudyRun | None:
        """Return the run that follows from a result, None if nothing does."""
        chain = RunId(run.design, run.point, run.contender, run.repeat)
        search = self._searches.get(chain)
        if search is None or search.done:
            return None
        if run.step == LOW:
            if good:
                return self._on_line(chain, HIGH, 1.0)
            search.done = True  # not even good where it begins
            self._spared += 1 + self._steps(run.design)
            return None
        share = search.runs[run.step]
        if run.step == HIGH and good:
            search.done = True  # good as far as the line goes
            self._spared += self._steps(run.design)
            return None
        search.low, search.high = (share, search.high) if good else (search.low, share)
        if run.step > self._steps(run.design):
            search.done = True
            return None
        return self._on_line(chain, run.step + 1, 0.5 * (search.low + search.high))

    def _on_line(self, chain: RunId, step: int, share: float) -> StudyRun:
        search = self._searches[chain]
        search.runs[step] = share
        values = search.line.at(share, self.study.parameters)
        run_id = RunId(chain.design, chain.point, chain.contender, chain.repeat, step)
        name = self.contenders[chain.contender]
        return StudyRun(run_id, name, values, search.line.name, share)

    def _each(self) -> Iterator[tuple[int, int]]:
        return product(range(len(self.contenders)), range(self.study.seeds))

    def _steps(self, name: str) -> int:
        design = self.study.designs[name]
        assert isinstance(design, BoundarySpec)
        return design.steps


def seed_of(study: StudySpec, run: RunId) -> int:
    """Return the seed of a run's noise and faults: the same for all controllers on a point."""
    text = f"{study.seed}/{run.design}/{run.point}/{run.repeat}"
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:4], "big") >> 1


def overrides_of(study: StudySpec, run: StudyRun) -> list[tuple[str, Any]]:
    """Return the paths that a run sets in its scenario, in order, and the values."""
    found = [*study.set.items(), *study.controllers[run.controller].set.items()]
    for name, value in run.values.items():
        spec = study.parameters[name]
        if spec.path is not None:
            found.append((spec.path, value))
        found += [(one.path, one.times * value) for one in spec.paths]
    return [*found, ("seed", seed_of(study, run.id))]
