"""Kernel of the load split: what share of the load each support gets, from where the ZMP is.

The wrench that the supports carry together pierces the plane through their centres at its ZMP. The
shares are the least ones, in squares about equal shares, whose centre of load lies as near to the
ZMP as the centres allow: of two feet the ZMP is projected on the line between them. Each stays at
or above a least share, so that a foot on the floor feels it.
"""

from __future__ import annotations

import math

import numpy as np

from equipoise.compiled import compiled, scratch, scratch_matrix
from equipoise.spatial.kernels import crossed

LEAST_SHARE = 0.01  # of the whole load, below which a foot that still stands is not unloaded
NARROW = 1e-6  # [m^2] spread of the centres across a direction in which they split nothing


@compiled
def loads_from_zmp(
    J: np.ndarray, rows: np.ndarray, ends: np.ndarray, normal_rows: np.ndarray,
    centres: np.ndarray, wrench: np.ndarray, loads: np.ndarray,
) -> float:  # fmt: skip
    """Write the load [n] of each support, as a multiple of the mean; return the mean [N].

    For a wrench [6] on the base. Support i has the rows of J that `rows` names up to `ends[i]`, the
    first three of them its axes; `centres` [n, 2] is where its middle is, along the first two. One
    without a normal row keeps 1. The mean is zero where nothing presses.
    """
    n, count = ends.shape[0], 0
    places, up = scratch_matrix(n, 3), scratch(3)
    middle = scratch(3)
    up[:] = middle[:] = 0.0
    start = 0
    for i in range(n):
        loads[i] = 1.0
        if normal_rows[i] >= 0:
            place_of(J, rows, start, centres[i], places[i])
            for c in range(3):
                up[c] += J[rows[start + 2], c]
                middle[c] += places[i, c]
            count += 1
        start = ends[i]
    size = math.sqrt(up[0] * up[0] + up[1] * up[1] + up[2] * up[2])
    if not size > 0.0:
        return 0.0
    for c in range(3):
        up[c] /= size
        middle[c] /= count
    pressed = up[0] * wrench[0] + up[1] * wrench[1] + up[2] * wrench[2]
    if not pressed > 0.0:
        return 0.0
    ax, ay, az = crossed(middle[0], middle[1], middle[2], wrench[0], wrench[1], wrench[2])
    zx, zy, zz = crossed(up[0], up[1], up[2], wrench[3] - ax, wrench[4] - ay, wrench[5] - az)
    spread_loads(places, middle, up, (zx / pressed, zy / pressed, zz / pressed), normal_rows, loads)
    return pressed / count


@compiled
def pressed_middles(
    ends: np.ndarray, normal_rows: np.ndarray, centres: np.ndarray, loads: np.ndarray, mean: float,
    out: np.ndarray,
) -> None:  # fmt: skip
    """Write the reaction [k] in which each support is pressed in its middle by its load."""
    out[:] = 0.0
    start = 0
    for i in range(ends.shape[0]):
        if normal_rows[i] >= 0:
            out[start + 2] = loads[i] * mean
            if ends[i] - start == 6:
                out[start + 3] = centres[i, 1] * out[start + 2]
                out[start + 4] = -centres[i, 0] * out[start + 2]
        start = ends[i]


@compiled
def place_of(
    J: np.ndarray, rows: np.ndarray, start: int, centre: np.ndarray, out: np.ndarray
) -> None:
    """Write where the middle of a support is [3], in axes of the base, from its own base columns.

    A row along e at the place p is `(e, p x e)`; over three axes e x (p x e) sums up to 2 p.
    """
    out[:] = 0.0
    for k in range(3):
        row = J[rows[start + k]]
        x, y, z = crossed(row[0], row[1], row[2], row[3], row[4], row[5])
        along = centre[k] if k < 2 else 0.0
        out[0] += 0.5 * x + along * row[0]
        out[1] += 0.5 * y + along * row[1]
        out[2] += 0.5 * z + along * row[2]


@compiled
def spread_loads(
    places: np.ndarray, middle: np.ndarray, up: np.ndarray, zmp: tuple[float, float, float],
    normal_rows: np.ndarray, loads: np.ndarray,
) -> None:  # fmt: skip
    """Write the loads for a ZMP that is off the middle by `zmp` [3]."""
    n, count = loads.shape[0], 0
    first = scratch(3)
    widest, length = 0.0, 0.0
    for i in range(n):  # the axes of the plane: towards the centre that is farthest, and across
        if normal_rows[i] < 0:
            continue
        count += 1
        height = 0.0
        for c in range(3):
            height += up[c] * (places[i, c] - middle[c])
        for c in range(3):
            places[i, c] -= middle[c] + height * up[c]
        length = places[i, 0] ** 2 + places[i, 1] ** 2 + places[i, 2] ** 2
        if length > widest:
            widest = length
            for c in range(3):
                first[c] = places[i, c]
    if not widest > NARROW:  # one foot, or all in one place
        return
    for c in range(3):
        first[c] /= math.sqrt(widest)
    sx, sy, sz = crossed(up[0], up[1], up[2], first[0], first[1], first[2])
    xx, xy, yy = 0.0, 0.0, 0.0
    for i in range(n):
        if normal_rows[i] < 0:
            continue
        a = first[0] * places[i, 0] + first[1] * places[i, 1] + first[2] * places[i, 2]
        b = sx * places[i, 0] + sy * places[i, 1] + sz * places[i, 2]
        places[i, 0], places[i, 1] = a, b
        xx, xy, yy = xx + a * a, xy + a * b, yy + b * b
    p = first[0] * zmp[0] + first[1] * zmp[1] + first[2] * zmp[2]
    q = sx * zmp[0] + sy * zmp[1] + sz * zmp[2]
    across = xx * yy - xy * xy
    if across > NARROW * xx:
        wx, wy = (yy * p - xy * q) / across, (xx * q - xy * p) / across
    else:
        wx, wy = p / xx, 0.0
    total = 0.0
    for i in range(n):
        if normal_rows[i] >= 0:
            share = 1.0 / count + wx * places[i, 0] + wy * places[i, 1]
            loads[i] = max(share * count, LEAST_SHARE * count)
            total += loads[i]
    for i in range(n):
        if normal_rows[i] >= 0:
            loads[i] *= count / total
