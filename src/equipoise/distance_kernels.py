"""Kernels over Coal's results: the least distance of each pair, and how fast distances change.

`results` [s, 10] holds a row a pair of shapes: distance, normal (from the first to the second),
nearest point of the first and of the second, in world axes.
"""

from __future__ import annotations

import numpy as np

from equipoise.compilation import compiled, entrance
from equipoise.kinematics_kernels import add_point_row


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
    for c in range(A.shape[1]):
        A[at, c] = 0.0
    normal = result[1:4]
    add_point_row(columns, carries[joint_second], result[7:10], normal, 1.0, A, at)
    add_point_row(columns, carries[joint_first], result[4:7], normal, -1.0, A, at)


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
