"""A point led to where it was dragged, no faster than a robot bears, and never far ahead of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from equipoise.spatial import Array


@dataclass(frozen=True)
class Pace:
    """How a point is led: `speed` [m/s] and `acceleration` [m/s^2] at most.

    It comes to rest with `near` [1/s]; it is led `leash` [m] ahead of where it is, no further, and
    given up after `patience` [s] in which it could not follow. Where joints go faster than `joints`
    [rad/s], which they do towards a stretched arm, it is led more slowly; at `least` [m/s] it
    counts as stuck.
    """

    speed: float = 0.5
    acceleration: float = 1.5
    near: float = 4.0
    leash: float = 0.012
    patience: float = 0.5
    joints: float = np.inf
    least: float = 0.02

    def speed_at(self, speed: float, joints: float) -> float:
        """Return how fast [m/s] to lead what goes at `speed` and makes joints go at `joints`."""
        if joints <= self.joints:
            return self.speed
        return min(max(speed * self.joints / joints, self.least), self.speed)


class Lead:
    """Leads one point from `place` (3,) [m] to a target that may change."""

    def __init__(self, place: Array, pace: Pace) -> None:
        self.pace, self.place = pace, np.array(place)
        self.velocity = np.zeros(3)
        self.waited = 0.0  # [s] that it could not follow

    @property
    def given_up(self) -> bool:
        """Whether it could not follow for too long."""
        return self.waited > self.pace.patience

    def go_on(self, target: Array, there: Array, seconds: float, joints: float = 0.0) -> bool:
        """Lead on for some time; `there` (3,) is where the point is now; tell if it can follow.

        `joints` [rad/s] is how fast the fastest joint goes.
        """
        pace = self.pace
        way, ahead = target - self.place, self.place - there
        speed = pace.speed_at(float(np.linalg.norm(self.velocity)), joints)
        wanted = way * min(speed / max(float(np.linalg.norm(way)), 1e-9), pace.near)
        far = float(np.linalg.norm(ahead))
        follows = far <= pace.leash
        if speed <= pace.least:  # the last of the way would take for ever
            self.waited += seconds
        if not follows:  # wait for it there, at rest
            self.place = self.place - ahead * (1.0 - pace.leash / far)
            self.velocity, wanted = np.zeros(3), np.zeros(3)
            self.waited += seconds
        if self.given_up:  # at its bound the best answer swings; at rest it does not
            self.place, wanted = np.array(there), np.zeros(3)
        change = wanted - self.velocity
        most = pace.acceleration * seconds / max(float(np.linalg.norm(change)), 1e-9)
        self.velocity = self.velocity + change * min(1.0, most)
        self.place = self.place + self.velocity * seconds
        return follows
