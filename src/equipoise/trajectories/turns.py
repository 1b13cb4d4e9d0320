"""Legs of a turning way: the short way from one rotation to the next, and rates along it."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pinocchio as pin

from equipoise.spatial import Array

HALF = 1e-6  # [rad] a turn this near to half a turn goes either way


def short_turns(rotations: Sequence[Array]) -> Array:
    """Return the rotation vector (m, 3) [rad] from each rotation to the next, of pi at most.

    It is the same in the axes of both. A half turn, which may go either way, goes on in the sense
    of the turn before it; those at the beginning go in the sense of the turn after them.
    """
    turns = np.array([pin.log3(A.T @ B) for A, B in pairwise(rotations)]).reshape(-1, 3)
    angles = np.linalg.norm(turns, axis=1)
    open_ = angles > np.pi - HALF
    sure = [k for k in range(len(turns)) if angles[k] > HALF and not open_[k]]
    sense = turns[sure[0]] if sure else np.zeros(3)
    for k in range(len(turns)):
        if open_[k] and turns[k] @ sense < 0.0:
            turns[k] *= 1.0 - 2.0 * np.pi / angles[k]
        if angles[k] > HALF:
            sense = turns[k]
    return turns


def end_rates(turn: Array, rate: Array, bend: Array) -> tuple[Array, Array]:
    """Return first and second derivative of a rotation vector that give a motion at `turn`.

    The motion is angular velocity `rate` and acceleration `bend` (3,) in the axes that turn:
    `omega = (I - g [x] + h [x]^2) dx/dt` for x the rotation vector.
    """
    g, h, g_slope, h_slope = _factors(float(np.linalg.norm(turn)))
    K = pin.skew(turn)
    J = np.eye(3) - g * K + h * K @ K
    first = np.linalg.solve(J, rate)
    across, along = K @ first, float(turn @ first)
    changing = -g_slope * along * across + h_slope * along * (K @ across)
    changing += h * np.cross(first, across)
    return first, np.linalg.solve(J, bend - changing)


def _factors(angle: float) -> tuple[float, float, float, float]:
    """Return `(1 - cos a) / a^2`, `(a - sin a) / a^3` and their slopes divided by a."""
    s = angle * angle
    if angle < 0.1:  # series: the next terms are below 1e-15
        return (
            0.5 - s / 24.0 + s**2 / 720.0 - s**3 / 40320.0 + s**4 / 3628800.0,
            1.0 / 6.0 - s / 120.0 + s**2 / 5040.0 - s**3 / 362880.0,
            -1.0 / 12.0 + s / 180.0 - s**2 / 6720.0 + s**3 / 453600.0,
            -1.0 / 60.0 + s / 1260.0 - s**2 / 60480.0 + s**3 / 4989600.0,
        )
    sine, cosine = float(np.sin(angle)), float(np.cos(angle))
    g, h = (1.0 - cosine) / s, (angle - sine) / (s * angle)
    return g, h, (sine / angle - 2.0 * g) / s, (g - 3.0 * h) / s
