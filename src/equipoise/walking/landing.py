"""A foot that feels the ground: its reference stops softly, and is led to where the foot stands."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from equipoise.trajectories.quintic import powers_between
from equipoise.walking.foot_path import (
    OFFSETS,
    FootPath,
    FootSample,
    constant,
    line,
    offset_from,
)


class Probe(FootPath):
    """A foot that was stopped by the ground too early: it slows, and goes on down softly.

    From pose and twist of the moment `start` [s] it comes within `halt` [s] to going straight down
    at `speed` [m/s], which it does for `search` [m].
    """

    def __init__(
        self, begin: FootSample, start: float, halt: float, speed: float, search: float
    ) -> None:
        self.start, self.slow_from = start, start + halt
        offset, rate = offset_from(begin.T_world_sole, begin)
        down, still = np.array([0.0, 0.0, -speed, 0.0, 0.0, 0.0]), np.zeros(OFFSETS)
        slow = offset + 0.5 * halt * (rate + down)
        halting = powers_between(
            halt, np.array([offset, rate, still]), np.array([slow, down, still])
        )
        searched = search / speed
        super().__init__(
            begin.T_world_sole, [start, self.slow_from, self.slow_from + searched],
            [halting, line(slow, down), constant(slow + searched * down)],
        )  # fmt: skip


class Glide(FootPath):
    """A foot on the ground whose reference stops, and is led to where the foot stands.

    From pose and twist of the moment `start` [s] it comes to rest within `halt` [s], by half of
    what it would have gone. Its load comes `wait` [s] later; then it goes to `T_to`, from rest to
    rest within `duration` [s]: a foot without load would be lifted by its reference.
    """

    def __init__(
        self, begin: FootSample, T_to: pin.SE3, start: float, duration: float, halt: float,
        wait: float = 0.0,
    ) -> None:  # fmt: skip
        self.T_to, self.start = T_to, start
        offset, rate = offset_from(T_to, begin)
        still, halts = np.zeros(OFFSETS), start + halt
        goes, rests = halts + wait, halts + wait + duration
        stopped = np.array([offset + 0.5 * halt * rate, still, still])
        stop = powers_between(halt, np.array([offset, rate, still]), stopped)
        back = powers_between(duration, stopped, np.zeros((3, OFFSETS)))
        super().__init__(
            T_to, [start, halts, goes, rests],
            [stop, constant(stopped[0]), back, constant(still)], rests,
        )  # fmt: skip
