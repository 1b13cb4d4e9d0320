"""The way of a foot: polynomials, one after the other, of an offset from a pose."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from equipoise.compiled import entrance, scratch_matrix
from equipoise.spatial import Array, pose_row
from equipoise.spatial.kernels import rotation_matrix, rotation_rate, turned
from equipoise.trajectories.base import ROW

POWERS, OFFSETS = 6, 6  # of a polynomial; place, then rotation vector


@dataclass(frozen=True)
class FootSample:
    """A foot's pose with twist and acceleration (6,) in world axes: linear, then angular."""

    T_world_sole: pin.SE3
    twist: Array
    acceleration: Array


class FootPath:
    """Pieces of the way of a foot, each a polynomial in the time since it began.

    `powers` (6, 6) of each piece, highest first, give an offset from the pose `origin`: a
    translation in world axes, and a rotation vector in the axes of the origin. The first piece
    stands at its begin before it begins, and a foot follows the last one for good; `rests_from` [s]
    is when it stands still.
    """

    def __init__(
        self, origin: pin.SE3, starts: Sequence[float], powers: Sequence[Array],
        rests_from: float = math.inf,
    ) -> None:  # fmt: skip
        self.origin, self.rests_from = origin, rests_from
        self._origin = pose_row(origin)
        self._starts = list(starts)
        self._powers = [np.ascontiguousarray(one) for one in powers]
        self._bend = np.zeros(OFFSETS)

    def write_row(self, t: float, rate: float, row: Array) -> None:
        """Write pose row and twist (18,) at time `t` [s] of a clock that goes at `rate`."""
        k = max(bisect_right(self._starts, t) - 1, 0)
        since = max(t - self._starts[k], 0.0)
        foot_on_piece(self._origin, self._powers[k], since, rate, row, self._bend)

    def at(self, t: float) -> FootSample:
        """Return the foot at time `t` [s].

        The angular acceleration is that of a turn about one axis.
        """
        row = np.zeros(ROW)
        self.write_row(t, 1.0, row)
        T = pin.SE3(row[:9].reshape(3, 3).T.copy(), row[9:12].copy())
        bend = np.concatenate((self._bend[:3], self.origin.rotation @ self._bend[3:]))
        return FootSample(T, row[12:].copy(), bend)


class Standing(FootPath):
    """A foot that stands."""

    def __init__(self, T_world_sole: pin.SE3) -> None:
        self.T_to = T_world_sole
        super().__init__(T_world_sole, [0.0], [constant(np.zeros(OFFSETS))], -math.inf)


def constant(offset: Array) -> Array:
    """Return the powers (6, 6) of a foot that stays at an offset (6,)."""
    return line(offset, np.zeros(OFFSETS))


def line(offset: Array, rate: Array) -> Array:
    """Return the powers (6, 6) of a foot that goes on from an offset (6,) at a rate (6,)."""
    powers = np.zeros((POWERS, OFFSETS))
    powers[-1], powers[-2] = offset, rate
    return powers


def shifted(powers: Array, by: float) -> Array:
    """Return the powers (6, k), highest first, of a polynomial from `by` behind its start on."""
    found = powers.copy()
    for last in range(len(found) - 1, 0, -1):
        for n in range(1, last + 1):
            found[n] += by * found[n - 1]
    return found


def offset_from(origin: pin.SE3, sample: FootSample) -> tuple[Array, Array]:
    """Return the offset (6,) of a foot from a pose, and its rate."""
    R, T = origin.rotation, sample.T_world_sole
    apart = pin.log3(R.T @ T.rotation)
    rate = pin.Jlog3(pin.exp3(apart)) @ (T.rotation.T @ sample.twist[3:])
    place = T.translation - origin.translation
    return np.concatenate((place, apart)), np.concatenate((sample.twist[:3], rate))


@entrance
def foot_on_piece(
    origin: np.ndarray, powers: np.ndarray, s: float, rate: float, row: np.ndarray, bend: np.ndarray
) -> None:
    """Write pose row and twist [18] at `s` [s] of a piece, and the offset's second derivative [6].

    `powers` [6, 6], highest first, are those of the offset from the pose row `origin` [12]; the
    twist is that of a clock that goes at `rate`.
    """
    offset = scratch_matrix(2, 6)
    for i in range(6):
        x = v = a = 0.0
        for n in range(6):
            a = a * s + 2.0 * v
            v = v * s + x
            x = x * s + powers[n, i]
        offset[0, i], offset[1, i], bend[i] = x, rate * v, a
    r = scratch_matrix(3, 3)
    rx, ry, rz = offset[0, 3], offset[0, 4], offset[0, 5]
    rotation_matrix(rx, ry, rz, r)
    for k in range(3):
        x, y, z = turned(origin, r[0, k], r[1, k], r[2, k])
        row[3 * k], row[3 * k + 1], row[3 * k + 2] = x, y, z
        row[9 + k], row[12 + k] = origin[9 + k] + offset[0, k], offset[1, k]
    wx, wy, wz = rotation_rate(rx, ry, rz, offset[1, 3], offset[1, 4], offset[1, 5])
    row[15], row[16], row[17] = turned(origin, wx, wy, wz)
