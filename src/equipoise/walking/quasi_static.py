"""The centre of mass of slow steps: moved over a foot before the other is lifted, then still."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from equipoise.spatial import Array
from equipoise.walking.centre import CentrePath, CentreState
from equipoise.walking.pieces import derivative, move, piece_at, value


@dataclass(frozen=True)
class CentreMove:
    """The centre of mass goes to `goal` (2,) [m] within `duration` [s], at minimum jerk."""

    duration: float
    goal: Array


class QuasiStaticPath(CentrePath):
    """Minimum-jerk moves of the centre of mass, one after the other; its ZMP is what they ask for.

    A move over D in T takes the zero-moment point `5.77 D / (omega T)^2` beyond its ends.
    """

    def __init__(
        self, omega: float, start: float, begin: Array, moves: Sequence[CentreMove]
    ) -> None:
        self.omega, self.start = omega, start
        self._durations = [one.duration for one in moves]
        edges = np.concatenate(([start], start + np.cumsum(self._durations)))
        self._starts, self.end = edges[:-1].tolist(), float(edges[-1])
        self._pieces, here = [], np.asarray(begin, dtype=float)
        for one in moves:
            powers = move(here, one.goal, one.duration)
            self._pieces.append(np.hstack([derivative(powers, order) for order in range(3)]))
            here = np.asarray(one.goal, dtype=float)

    def at(self, t: float) -> CentreState:
        """Return where it is at time `t` [s]; it rests before its start and behind its end."""
        k = piece_at(self._starts, t)
        s = min(max(t - self._starts[k], 0.0), self._durations[k])
        p, v, a = value(self._pieces[k], s).reshape(3, 2)
        return CentreState(p, v, a, p - a / self.omega**2, p + v / self.omega)
