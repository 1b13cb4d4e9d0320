"""Polynomials one after the other, in the time since each began."""

from __future__ import annotations

from bisect import bisect_right

import numpy as np

from equipoise.spatial import Array

STEP = np.array([0.0, 0.0, 0.0, 10.0, -15.0, 6.0])  # the minimum-jerk step of a unit of time
BUMP = np.array([0.0, 0.0, 16.0, -32.0, 16.0, 0.0])  # 16 x^2 (1 - x)^2: one at its middle
PUSH = np.array([0.0, 60.0, -180.0, 120.0, 0.0, 0.0])  # the second derivative of the step
POWERS = len(STEP)
_DERIVE = np.diag(np.arange(1.0, POWERS), 1)


def move(start: Array, goal: Array, duration: float) -> Array:
    """Return the powers (6, k), lowest first, of a minimum-jerk move between two points (k,)."""
    powers = np.outer(_slowed(STEP, duration), goal - start)
    powers[0] += start
    return powers


def bump(height: Array, duration: float) -> Array:
    """Return the powers (6, k) of what rises to `height` (k,) and falls."""
    return np.outer(_slowed(BUMP, duration), height)


def push(way: Array, duration: float) -> Array:
    """Return the powers (6, k) of the acceleration [m/s^2] of a minimum-jerk move by `way` (k,)."""
    return np.outer(_slowed(PUSH, duration), way / duration**2)


def derivative(powers: Array, order: int = 1) -> Array:
    """Return the powers (6, k) of a derivative."""
    for _ in range(order):
        powers = _DERIVE @ powers
    return powers


def value(powers: Array, s: float) -> Array:
    """Return a polynomial (k,) at `s` [s] after its start."""
    s2 = s * s
    s3 = s2 * s
    total: Array = np.array([1.0, s, s2, s3, s2 * s2, s3 * s2]) @ powers
    return total


def piece_at(starts: list[float], t: float) -> int:
    """Return the number of the piece in which `t` lies; the first before, the last behind all."""
    return min(max(bisect_right(starts, t) - 1, 0), len(starts) - 1)


def _slowed(powers: Array, duration: float) -> Array:
    """Return the powers of a polynomial of the unit interval, spread over a duration [s]."""
    return powers / duration ** np.arange(len(powers))
