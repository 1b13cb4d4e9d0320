"""Where the centre of mass has to be besides its plan, so that what hands push turns nobody over.

A force F on the robot at the height z turns it as much as its weight a distance F z / (M g) away.
The zero-moment point stays where it is planned if the centre of mass follows a pendulum of its own,
`e'' = omega^2 (e - d)` with `d = -F z / (M g)`; of its solutions one stays bounded.
"""

from __future__ import annotations

import numpy as np

from equipoise.errors import InputError
from equipoise.spatial import Array
from equipoise.spatial.numbers import positive


class Leaning:
    """The bounded way (N, 2) [m] of a pendulum over the point `d` (N, 2) [m], every `dt` [s].

    It begins at rest where `d` begins, and leads: it moves before the force does. Behind the last
    sample it stays there.
    Raises: `InputError`.
    """

    def __init__(self, omega: float, dt: float, d: Array) -> None:
        omega, self._dt = positive("the rate of a pendulum", omega), positive("the period", dt)
        d = np.asarray(d, dtype=float)
        if d.ndim != 2 or d.shape[0] < 2 or d.shape[1] != 2 or not np.isfinite(d).all():
            raise InputError("a leaning needs two finite points (N, 2) at least", given=d.shape)
        dies = np.exp(-omega * dt)
        dcm = d.copy()
        slopes = np.diff(d, axis=0) / (omega * dt)
        for k in range(len(d) - 2, -1, -1):  # backwards, which is where it is stable
            dcm[k] = d[k] + slopes[k] + (dcm[k + 1] - d[k + 1] - slopes[k]) * dies
        self.p = np.empty_like(d)
        self.p[0] = d[0]
        slopes = np.diff(dcm, axis=0) / (omega * dt)
        for k in range(len(d) - 1):
            self.p[k + 1] = dcm[k + 1] - slopes[k] + (self.p[k] - dcm[k] + slopes[k]) * dies
        self.v = omega * (dcm - self.p)
        self.v[-1] = 0.0

    def at(self, t: float) -> tuple[Array, Array]:
        """Return how far aside (2,) [m], and its rate [m/s], at the sample next to `t` [s]."""
        k = min(max(round(t / self._dt), 0), len(self.p) - 1)
        return self.p[k], self.v[k]
