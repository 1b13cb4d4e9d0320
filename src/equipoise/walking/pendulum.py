"""The centre of mass of an inverted pendulum over a given zero-moment point, in closed form.

With `c'' = omega^2 (c - p)` the divergent component `xi = c + c' / omega` obeys
`xi' = omega (xi - p)` and grows away from p: only one of its solutions stays bounded, and it is
found backwards from the end. The rest, `c' = omega (xi - c)`, decays and is found forwards.
On a piece on which p is a polynomial,

    c = sum_j p^(2j) / omega^(2j) + A exp(omega (s - T)) + B exp(-omega s),

A from the end of the piece and B from its start. Source: Kajita et al. 2001 (the pendulum);
Englsberger, Ott and Albu-Schaeffer 2015 (its divergent component, backwards).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from equipoise.spatial import Array
from equipoise.walking.centre import CentrePath, CentreState
from equipoise.walking.pieces import POWERS, bump, derivative, move, piece_at, push, value


@dataclass(frozen=True)
class ZmpMove:
    """The zero-moment point goes to `goal` (2,) [m] within `duration` [s], at minimum jerk.

    With `bends` the piece may be bent aside: what is needed to begin, or to end, as is wanted.
    `pushed` (2,) [m s^2] is how far what swings by minimum jerk meanwhile pushes it away, for each
    m/s^2: the pendulum's own zero-moment point gives way by as much.
    """

    duration: float
    goal: Array
    bends: bool = False
    pushed: Array | None = None


class PendulumPath(CentrePath):
    """Centre of mass and its divergent component over moves of the zero-moment point.

    It begins at time `start` [s] at `c` (2,) with the divergent component `dcm` (2,) [m] and the
    zero-moment point `zmp` (2,), and ends at rest above the last goal. The bounded solution has a
    divergent component of its own: the first move that `bends` is bent so that it is the given one,
    the last one so that the end is at rest, both by bumps as high as `bends` (2, 2) [m].
    """

    def __init__(
        self, omega: float, start: float, begin: CentreState, moves: Sequence[ZmpMove]
    ) -> None:
        self.omega, self.start = omega, start
        self._durations = [one.duration for one in moves]
        edges = np.concatenate(([start], start + np.cumsum(self._durations)))
        self._starts, self.end = edges[:-1].tolist(), float(edges[-1])
        plain = []
        zmp = np.asarray(begin.zmp, dtype=float)
        for one in moves:
            powers = move(zmp, one.goal, one.duration)
            if one.pushed is not None:
                powers = powers - push(one.pushed, one.duration)
            plain.append(powers)
            zmp = np.asarray(one.goal, dtype=float)
        bending = [k for k, one in enumerate(moves) if one.bends]
        first, last = bending[0], bending[-1]
        self.bends = self._bend(begin, plain, first, last)
        for k, height in zip((first, last), self.bends, strict=True):
            plain[k] = plain[k] + bump(height, self._durations[k])
        self._zmp = plain
        self._solve(begin.p)

    def _bend(self, begin: CentreState, plain: list[Array], first: int, last: int) -> Array:
        """Return how high the bumps (2, 2) are, from two unit answers of the same equations."""
        still = [np.zeros((POWERS, 1)) for _ in plain]
        reached = [self._ends(plain, begin.p)]
        for k in (first, last):
            unit = list(still)
            unit[k] = bump(np.ones(1), self._durations[k])
            reached.append(self._ends(unit, np.zeros(1)))
        (dcm, end), one, other = reached
        answers = np.array([[one[0][0], other[0][0]], [one[1][0], other[1][0]]])
        wanted = np.array([begin.dcm - dcm, value(plain[-1], self._durations[-1]) - end])
        if first == last:  # one bump cannot do both: the start is kept
            return np.array([wanted[0] / answers[0, 0], np.zeros(2)])
        return np.linalg.solve(answers, wanted)

    def _ends(self, zmp: list[Array], c: Array) -> tuple[Array, Array]:
        """Return the divergent component at the start and the centre at the end."""
        grown, start = self._backwards(zmp)
        for powers, T, A in zip(zmp, self._durations, grown, strict=True):
            particular = self._particular(powers)
            decay = math.exp(-self.omega * T)
            B = c - value(particular, 0.0) - A * decay
            c = value(particular, T) + A + B * decay
        return start, c

    def _solve(self, c: Array) -> None:
        grown, _ = self._backwards(self._zmp)
        self._pieces, self._plain = [], []
        for powers, T, A in zip(self._zmp, self._durations, grown, strict=True):
            particular = self._particular(powers)
            decay = math.exp(-self.omega * T)
            B = c - value(particular, 0.0) - A * decay
            c = value(particular, T) + A + B * decay
            self._pieces.append((np.hstack((particular, derivative(particular), powers)), A, B))
            # x and y in plain numbers, highest power first, which are read every tick
            plain = [
                (*particular[::-1, k].tolist(), float(A[k]), float(B[k])) for k in range(len(c))
            ]
            self._plain.append(plain)

    def _backwards(self, zmp: list[Array]) -> tuple[list[Array], Array]:
        """Return what grows (A) of each piece, and the bounded divergent component at the start."""
        dcm = value(zmp[-1], self._durations[-1])
        grown = []
        for powers, T in zip(reversed(zmp), reversed(self._durations), strict=True):
            particular = self._particular(powers)
            both = particular + derivative(particular) / self.omega
            A = 0.5 * (dcm - value(both, T))
            dcm = value(both, 0.0) + 2.0 * A * math.exp(-self.omega * T)
            grown.append(A)
        return grown[::-1], dcm

    def _particular(self, powers: Array) -> Array:
        """Return the powers of the answer that neither grows nor decays."""
        total, term = powers.copy(), powers
        for _ in range(POWERS // 2):
            term = derivative(term, 2) / self.omega**2
            total += term
        return total

    def motion(self, t: float) -> tuple[float, float, float, float]:
        """Return position [m] and velocity [m/s] at time `t` [s] as plain numbers: x, y, x', y'."""
        if t >= self.end:
            return super().motion(t)
        k = piece_at(self._starts, t)
        s, T, omega = max(t - self._starts[k], 0.0), self._durations[k], self.omega
        growth, decay = math.exp(omega * (s - T)), math.exp(-omega * s)
        found = []
        for a5, a4, a3, a2, a1, a0, A, B in self._plain[k]:
            grows, decays = A * growth, B * decay
            place = ((((a5 * s + a4) * s + a3) * s + a2) * s + a1) * s + a0
            speed = (((5.0 * a5 * s + 4.0 * a4) * s + 3.0 * a3) * s + 2.0 * a2) * s + a1
            found.append((place + grows + decays, speed + omega * (grows - decays)))
        (x, vx), (y, vy) = found
        return x, y, vx, vy

    def at(self, t: float) -> CentreState:
        """Return where it is at time `t` [s]; it rests before its start and behind its end."""
        omega = self.omega
        if t >= self.end:
            p = value(self._zmp[-1], self._durations[-1])
            return CentreState(p, np.zeros(2), np.zeros(2), p, p)
        k = piece_at(self._starts, t)
        s, T = max(t - self._starts[k], 0.0), self._durations[k]
        powers, A, B = self._pieces[k]
        grows, decays = A * math.exp(omega * (s - T)), B * math.exp(-omega * s)
        p, v, zmp = value(powers, s).reshape(3, 2)
        p = p + grows + decays
        v = v + omega * (grows - decays)
        return CentreState(p, v, omega**2 * (p - zmp), zmp, p + v / omega)
