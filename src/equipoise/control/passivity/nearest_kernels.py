"""Kernels that find the velocity nearest to another one, in the metric of K_d, on given contacts.

`K_d = U U^T` with U upper triangular. In coordinates `z = U^T x` the metric is Euclidean, and the
contact rows J are `J U^-T`: the factorisation of `contacts.factor` works on those.
"""

from __future__ import annotations

import numpy as np

from equipoise.compiled import compiled, scratch, scratch_matrix
from equipoise.contacts.factor import column, factorise, lift


@compiled
def factorise_in_metric(
    J: np.ndarray, unroot: np.ndarray, L: np.ndarray, reflectors: np.ndarray, pivots: np.ndarray,
    tolerance: float,
) -> int:  # fmt: skip
    """Factorise `J U^-T` [r, nv], with `unroot = U^-T` lower triangular; return the rank."""
    r, nv = J.shape
    seen = scratch_matrix(r, nv)
    seen[:, :] = 0.0
    for i in range(r):
        for k in range(nv):
            along = J[i, k]
            if along != 0.0:  # a row knows the joints of one or two limbs
                for c in range(column(k + 1)):
                    seen[i, c] += along * unroot[k, c]
    return factorise(seen, L, reflectors, pivots, tolerance)


@compiled
def move_to_nearest(
    J: np.ndarray, unroot: np.ndarray, L: np.ndarray, reflectors: np.ndarray, pivots: np.ndarray,
    rank: int, wanted: np.ndarray, x: np.ndarray,
) -> None:  # fmt: skip
    """Change x [nv] as little as the metric can tell, so that `J x = wanted` [r].

    That is `x + J^# (wanted - J x)` with `J^# = K_d^-1 J^T (J K_d^-1 J^T)^-1`.
    """
    r, nv = J.shape
    missing, z = scratch(r), scratch(nv)
    for i in range(r):
        total = wanted[i]
        for c in range(column(nv)):
            total -= J[i, c] * x[c]
        missing[i] = total
    lift(L, reflectors, pivots, rank, missing, z)
    for i in range(nv):
        total = 0.0
        for c in range(column(i + 1)):
            total += unroot[i, c] * z[c]
        x[i] += total
