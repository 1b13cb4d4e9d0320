"""A scalar that is led from value to value by minimum-jerk moves that may overlap."""

from __future__ import annotations

from dataclasses import dataclass

from equipoise.trajectories.minimum_jerk import step, step_rate


@dataclass(frozen=True)
class Change:
    """A change by `by` between two times [s]."""

    start: float
    end: float
    by: float


@dataclass(frozen=True)
class Track:
    """A value that begins at `start` and changes; the sum of its moves, so that it never jumps."""

    start: float
    changes: tuple[Change, ...] = ()

    def at(self, t: float) -> tuple[float, float]:
        """Return value and rate at time `t` [s]."""
        value, rate = self.start, 0.0
        for one in self.changes:
            if t >= one.end:
                value += one.by
            elif t > one.start:
                x = (t - one.start) / (one.end - one.start)
                value += one.by * step(x)
                rate += one.by * step_rate(x) / (one.end - one.start)
        return value, rate

    @property
    def final(self) -> float:
        """The value after all changes."""
        return self.start + sum(one.by for one in self.changes)

    def before(self, t: float) -> Track:
        """Return the track without the changes that have not begun by time `t` [s]."""
        done = [one for one in self.changes if one.end <= t]
        kept = tuple(one for one in self.changes if one.start < t < one.end)
        return Track(self.start + sum(one.by for one in done), kept)

    def then(self, start: float, end: float, by: float) -> Track:
        """Return the track with one more change."""
        if by == 0.0:
            return self
        return Track(self.start, (*self.changes, Change(start, end, by)))
