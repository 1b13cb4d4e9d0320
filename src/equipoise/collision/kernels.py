"""Kernels over Coal's results: the least distance of each pair, and how fast distances change.

`results` [s, 10] holds a row a pair of shapes: distance, normal (from the first to the second),
nearest point of the first and of the second, in world axes.
"""

from __future__ import annotations

import numpy as np

from equipoise.compiled.compilation import compiled, entrance
from equipoise.spatial.kernels import crossed


@entrance
def least_of_pairs(
    results: np.ndarray, starts: np.ndarray, distances: np.ndarray, nearest: np.ndarray
) -> None:
    """Write for each pair the least distance of its shapes starts[k]..starts[k + 1], and which."""
    for k in range(len(distances)):
        best = starts[k]
        for i in range(starts[k] + 1, starts[k + 1]):
            if results[i, 0] < results[best, 0]:
                best = i
        nearest[k], distances[k] = best, results[best, 0]


@compiled
def rate_of_distance(
    columns: np.ndarray,
    carries: np.ndarray,
    result: np.ndarray,
    joint_first: int,
    joint_second: int,
    A: np.ndarray,
    at: int,
) -> None:
    """Write to A[at] the rate of one distance: the second point's speed minus the first's."""
    nx, ny, nz = result[1], result[2], result[3]
    ax, ay, az = crossed(result[7], result[8], result[9], nx, ny, nz)
    bx, by, bz = crossed(result[4], result[5], result[6], nx, ny, nz)
    for c in range(A.shape[1]):
        second, first = carries[joint_second, c], carries[joint_first, c]
        if second == first == 0.0:
            A[at, c] = 0.0
            continue
        wx, wy, wz = columns[c, 3], columns[c, 4], columns[c, 5]
        along = nx * columns[c, 0] + ny * columns[c, 1] + nz * columns[c, 2]
        A[at, c] = second * (along + ax * wx + ay * wy + az * wz) - first * (
            along + bx * wx + by * wy + bz * wz
        )


@entrance
def rates_of_distances(
    columns: np.ndarray,
    carries: np.ndarray,
    results: np.ndarray,
    chosen: np.ndarray,
    joint_ids: np.ndarray,
    A: np.ndarray,
    at: int,
) -> None:
    """Write from A[at] on the rates of the `chosen` results, between bodies of `joint_ids`."""
    for k in range(len(chosen)):
        rate_of_distance(
            columns, carries, results[chosen[k]], joint_ids[k, 0], joint_ids[k, 1], A, at + k
        )
