"""The quintic spline through points, at rest at both ends: the way of least jerk between rests."""

from __future__ import annotations

import numpy as np

from equipoise.spatial import Array


def quintic_powers(times: Array, points: Array) -> Array:
    """Return the powers (m, 6, k), highest first, of each piece between `points` (m + 1, k).

    A piece is a polynomial in the time [s] since its start. Velocity and acceleration are zero at
    the first and the last of the `times` (m + 1,) [s], and four derivatives are continuous at the
    others, which makes the integral of the squared third derivative the least.
    """
    steps = np.diff(times)
    pieces = [_powers_of_ends(h) for h in steps]
    nodes, k = len(times), points.shape[1]
    states = np.zeros((nodes, 3, k))  # position, velocity, acceleration
    states[:, 0] = points
    inner = [(n, d) for n in range(1, nodes - 1) for d in (1, 2)]
    if inner:
        jumps = np.zeros((len(inner), nodes, 3))
        for row, (n, d) in enumerate(inner):
            jumps[row, n - 1 : n + 1] += _derivative(pieces[n - 1], d + 2, steps[n - 1])
            jumps[row, n : n + 2] -= _derivative(pieces[n], d + 2, 0.0)
        known = np.einsum("rnd,ndk->rk", jumps, states)
        unknown = np.array([[row[n, d] for n, d in inner] for row in jumps])
        for (n, d), value in zip(inner, np.linalg.solve(unknown, -known), strict=True):
            states[n, d] = value
    ends = np.stack([states[:-1], states[1:]], axis=1)
    return np.array([np.einsum("pnd,ndk->pk", P, x) for P, x in zip(pieces, ends, strict=True)])


def powers_between(h: float, start: Array, end: Array) -> Array:
    """Return the powers (6, k), highest first, of the quintic with these states at its ends.

    `start` and `end` (3, k) are value, first and second derivative; `h` [s] lies between them.
    """
    return np.einsum("pnd,ndk->pk", _powers_of_ends(h), np.stack((start, end)))


def _powers_of_ends(h: float) -> Array:
    """Return the matrix (6, 2, 3) from the states at both ends of a piece to its powers."""
    derivatives, powers = np.arange(3.0), np.arange(5.0, -1.0, -1.0)
    return OF_UNIT * h**derivatives / (h**powers)[:, None, None]


def _of_unit() -> Array:
    """Return `_powers_of_ends` for a piece of unit length."""
    ends = [
        [0, 0, 0, 0, 0, 1],
        [0, 0, 0, 0, 1, 0],
        [0, 0, 0, 2, 0, 0],
        [1, 1, 1, 1, 1, 1],
        [5, 4, 3, 2, 1, 0],
        [20, 12, 6, 2, 0, 0],
    ]
    return np.linalg.inv(np.array(ends, dtype=float)).round(9).reshape(6, 2, 3)


def _derivative(powers: Array, order: int, s: float) -> Array:
    """Return a derivative at `s` [s] after the start of a piece with these powers (6, ...)."""
    while order:
        degrees = np.arange(len(powers) - 1, 0, -1).reshape(-1, *(1,) * (powers.ndim - 1))
        powers, order = powers[:-1] * degrees, order - 1
    value = np.zeros(powers.shape[1:])
    for power in powers:
        value = value * s + power
    return value


OF_UNIT = _of_unit()  # its entries are whole numbers and halves
