"""A foot that feels the ground: its reference stops softly, and is led to where the foot stands."""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin

from equipoise.spatial import Array
from equipoise.trajectories.quintic import powers_between
from equipoise.walking.swing import FootSample, Standing, Swing, with_derivatives


class _Offset:
    """Poses given as an offset (6,) from a pose: a translation, and a rotation vector after it."""

    def __init__(self, origin: pin.SE3) -> None:
        self.origin = origin

    def of(self, sample: FootSample) -> tuple[Array, Array]:
        """Return offset and its rate."""
        R, T = self.origin.rotation, sample.T_world_sole
        apart = pin.log3(R.T @ T.rotation)
        rate = pin.Jlog3(pin.exp3(apart)) @ (T.rotation.T @ sample.twist[3:])
        place = T.translation - self.origin.translation
        return np.concatenate((place, apart)), np.concatenate((sample.twist[:3], rate))

    def sample(self, x: Array, v: Array, a: Array) -> FootSample:
        """Return the foot; the acceleration is that across and upwards only."""
        R = self.origin.rotation @ pin.exp3(x[3:])
        spin = R @ (pin.Jexp3(x[3:]) @ v[3:])
        return FootSample(
            pin.SE3(R, self.origin.translation + x[:3]),
            np.concatenate((v[:3], spin)),
            np.concatenate((a[:3], np.zeros(3))),
        )


class Probe:
    """A foot that was stopped by the ground too early: it slows, and goes on down softly.

    From pose and twist of the moment `start` [s] it comes within `halt` [s] to going straight down
    at `speed` [m/s], which it does for `search` [m].
    """

    rests_from = math.inf

    def __init__(
        self, begin: FootSample, start: float, halt: float, speed: float, search: float
    ) -> None:
        self.start, self.slow_from, self._speed = start, start + halt, speed
        self._search = search / speed
        self._offset = _Offset(begin.T_world_sole)
        offset, rate = self._offset.of(begin)
        self._down = np.array([0.0, 0.0, -speed, 0.0, 0.0, 0.0])
        self._end = offset + 0.5 * halt * (rate + self._down)
        still = np.zeros(6)
        self._powers = powers_between(
            halt, np.array([offset, rate, still]), np.array([self._end, self._down, still])
        )

    def at(self, t: float) -> FootSample:
        """Return the foot at time `t` [s]."""
        if t < self.slow_from:
            return self._offset.sample(*with_derivatives(self._powers, max(t - self.start, 0.0)))
        gone = t - self.slow_from
        down = self._down if gone < self._search else 0.0 * self._down
        x = self._end + min(gone, self._search) * self._down
        return self._offset.sample(x, down, np.zeros(6))


class Glide:
    """A foot on the ground whose reference stops, and is led to where the foot stands.

    From pose and twist of the moment `start` [s] it comes to rest within `halt` [s], by half of
    what it would have gone. Its load comes `wait` [s] later; then it goes to `T_to`, from rest to
    rest within `duration` [s]: a foot without load would be lifted by its reference.
    """

    def __init__(
        self, begin: FootSample, T_to: pin.SE3, start: float, duration: float, halt: float,
        wait: float = 0.0,
    ) -> None:  # fmt: skip
        self.T_to, self.start, self._halts = T_to, start, start + halt
        self._goes = self._halts + wait
        self.rests_from = self._goes + duration
        self._offset = _Offset(T_to)
        offset, rate = self._offset.of(begin)
        still = np.zeros(6)
        stopped = np.array([offset + 0.5 * halt * rate, still, still])
        self._stop = powers_between(halt, np.array([offset, rate, still]), stopped)
        self._back = powers_between(duration, stopped, np.zeros((3, 6)))

    def at(self, t: float) -> FootSample:
        """Return the foot at time `t` [s]."""
        if t < self._halts:
            powers, s = self._stop, max(t - self.start, 0.0)
        else:
            powers, s = self._back, max(min(t, self.rests_from) - self._goes, 0.0)
        return self._offset.sample(*with_derivatives(powers, s))


FootPath = Swing | Probe | Glide | Standing
