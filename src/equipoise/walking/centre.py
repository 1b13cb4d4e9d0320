"""The wanted centre of mass over time, with its zero-moment point, whatever the mode is."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import NamedTuple

from equipoise.spatial import Array


class CentreState(NamedTuple):
    """Over the ground (2,): position [m], velocity, acceleration; zero-moment and DCM point [m].

    The divergent component of motion is `dcm = p + v / omega`; the zero-moment point belongs to a
    pendulum of constant height: `zmp = p - a / omega^2`.
    """

    p: Array
    v: Array
    a: Array
    zmp: Array
    dcm: Array


class CentrePath(ABC):
    """Where the centre of mass goes, from `start` to `end` [s]; it rests behind its end."""

    omega: float
    start: float
    end: float

    @abstractmethod
    def at(self, t: float) -> CentreState:
        """Return where it is at time `t` [s]."""

    def motion(self, t: float) -> tuple[float, float, float, float]:
        """Return position [m] and velocity [m/s] at time `t` [s] as plain numbers: x, y, x', y'."""
        state = self.at(t)
        x, y = state.p.tolist()
        vx, vy = state.v.tolist()
        return x, y, vx, vy
