"""Small dense quadratic programs: equalities eliminated, inequalities left to DAQP.

DAQP solves the problem that is left once the equalities are met exactly, from a cold start: the
same numbers give the same bits, whatever was solved before.
"""

from __future__ import annotations

from dataclasses import dataclass

import daqp
import numpy as np
from numpy.typing import NDArray

from equipoise.optional import require_package
from equipoise.spatial import Array

RANK = 1e-10  # of the largest pivot, below which an equality repeats others
HELD = 1e-9  # [unit of the row] by which a bound may be missed without asking DAQP
SOLVED = (1, 2)
SOFT = 8  # DAQP's word for a row that may be violated


@dataclass(frozen=True)
class Answer:
    """`x` (n,) and whether it is the optimum; `bounded` tells whether a bound had a say."""

    x: Array
    solved: bool
    bounded: bool


def minimise(
    metric: Array, goal: Array, equal: tuple[Array, Array], bounds: tuple[Array, Array, Array],
    soft: NDArray[np.bool_] | None = None,
) -> Answer:  # fmt: skip
    """Minimise `|metric (x - goal)|^2` with `E x = e` and `lower <= A x <= upper`.

    `metric` (n, n) is regular, or its diagonal (n,). `equal` is (E, e), `bounds` (A, lower, upper).
    Equalities that repeat others are met as well as the others allow. If the rest cannot be met,
    the rows marked in `soft` (m,) may be violated, as little as possible; `solved` is then False.
    """
    B = np.diag(1.0 / metric) if metric.ndim == 1 else np.linalg.inv(metric)
    start, Z = _eliminated(equal[0] @ B, equal[1])
    wanted = metric * goal if metric.ndim == 1 else metric @ goal
    # x = B (start + Z z): with orthonormal Z the cost is |z - Z^T (wanted - start)|^2 + constant
    z = Z.T @ (wanted - start)
    x = B @ (start + Z @ z)
    A, lower, upper = bounds
    at = A @ x
    if (at >= lower - HELD).all() and (at <= upper + HELD).all():
        return Answer(x, True, False)
    AB = A @ B
    C, offset = np.ascontiguousarray(AB @ Z), AB @ start
    for allowed in (None, soft):
        sense = np.zeros(len(lower), dtype=np.int32)
        if allowed is not None:
            sense[allowed] = SOFT
        found, _, flag, _ = daqp.solve(
            np.eye(len(z)), -z, C, upper - offset, lower - offset, sense, primal_tol=1e-8
        )
        if flag in SOLVED:
            return Answer(B @ (start + Z @ np.array(found)), allowed is None, True)
        if soft is None:
            break
    return Answer(x, False, True)


def _eliminated(E: Array, e: Array) -> tuple[Array, Array]:
    """Return the least y (n,) with `E y = e`, and orthonormal columns that E does not see."""
    if not len(E):
        return np.zeros(E.shape[1]), np.eye(E.shape[1])
    require_package("scipy", "scipy", "a rival controller")
    import scipy.linalg

    Q, R, order = scipy.linalg.qr(E.T, pivoting=True, check_finite=False)
    pivots = np.abs(np.diag(R))
    rank = int((pivots > RANK * pivots[0]).sum())
    y = scipy.linalg.solve_triangular(R[:rank, :rank], e[order[:rank]], trans=1, check_finite=False)
    return Q[:, :rank] @ y, Q[:, rank:]
