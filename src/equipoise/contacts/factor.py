"""Kernels of the pivoted orthogonal factorisation of contact rows: its projector, its inverse.

`J[pivots] = L Q1^T` with L lower trapezoidal (r, rank) and Q1 (nv, rank) orthonormal, kept as
reflectors: row k of `reflectors` is a vector u of length sqrt(2), zero before column k, and Q1 is
the first columns of the product of all `I - u u^T`.
"""

from __future__ import annotations

import math

import numpy as np

from equipoise.compiled import compiled, entrance, inlined, scratch, scratch_matrix

column = np.uint64  # the compiler makes better loops of unsigned columns


@compiled
def factorise(
    J: np.ndarray, L: np.ndarray, reflectors: np.ndarray, pivots: np.ndarray, tolerance: float
) -> int:
    """Factorise J [r, nv]; return the rank: rows beyond have less than `tolerance` of the first."""
    r, nv = J.shape
    squares, once = scratch(r), scratch(r)  # of what is left of a row: now, when last summed up
    for i in range(r):
        pivots[i] = i
        total = 0.0
        for c in range(column(nv)):
            L[i, c] = J[i, c]
            total += J[i, c] * J[i, c]
        squares[i] = once[i] = total
    largest = 0.0
    for k in range(min(r, nv)):
        best = k
        for i in range(k + 1, r):
            if squares[i] > squares[best]:
                best = i
        length = norm_from(L, best, k)
        if k == 0:
            largest = length
        if not length > tolerance * largest:
            return k
        if best != k:
            pivots[k], pivots[best] = pivots[best], pivots[k]
            squares[best], once[best] = squares[k], once[k]
            for c in range(column(nv)):
                L[k, c], L[best, c] = L[best, c], L[k, c]
        first = L[k, k]
        kept = -length if first >= 0.0 else length
        scale = 1.0 / math.sqrt(length * (length + abs(first)))
        for c in range(column(k)):
            reflectors[k, c] = 0.0
        for c in range(column(k), column(nv)):
            reflectors[k, c] = L[k, c] * scale
        reflectors[k, k] = (first - kept) * scale
        L[k, k] = kept
        for i in range(k + 1, r):
            reflect(reflectors, k, L, i)
            squares[i] -= L[i, k] * L[i, k]
            if squares[i] < 1e-4 * once[i]:  # the difference has lost its digits
                squares[i] = once[i] = norm_from(L, i, k + 1) ** 2
    return min(r, nv)


@compiled
def norm_from(x: np.ndarray, i: int, start: int) -> float:
    """Return the length of x[i, start:]."""
    total = 0.0
    for c in range(column(start), column(x.shape[1])):
        total += x[i, c] * x[i, c]
    return math.sqrt(total)


@inlined
def reflect(reflectors: np.ndarray, k: int, x: np.ndarray, i: int) -> None:
    """Apply reflector k to x[i]; it is zero before column k, so one may start a little earlier."""
    along, start, end = 0.0, column(k - k % 4), column(x.shape[1])
    for c in range(start, end):
        along += x[i, c] * reflectors[k, c]
    for c in range(start, end):
        x[i, c] -= along * reflectors[k, c]


@compiled
def project(reflectors: np.ndarray, rank: int, x: np.ndarray, out: np.ndarray) -> None:
    """Write `x - Q1 Q1^T x` to `out`."""
    row = out.reshape(1, -1)
    for c in range(column(x.shape[0])):
        row[0, c] = x[c]
    for k in range(rank):
        reflect(reflectors, k, row, 0)
    for k in range(rank):
        row[0, k] = 0.0
    for k in range(rank - 1, -1, -1):
        reflect(reflectors, k, row, 0)


@compiled
def lift(
    L: np.ndarray,
    reflectors: np.ndarray,
    pivots: np.ndarray,
    rank: int,
    y: np.ndarray,
    out: np.ndarray,
) -> None:
    """Write to `out` [nv] the least x with J x = y [r], in the least squares sense if need be."""
    r = y.shape[0]
    row = out.reshape(1, -1)
    row[0, :] = 0.0
    if rank == r:
        for k in range(r):
            total = y[pivots[k]]
            for c in range(k):
                total -= L[k, c] * row[0, c]
            row[0, k] = total / L[k, k]
    else:
        permuted, trapezoid = scratch(r), scratch_matrix(r, rank)
        for i in range(r):
            permuted[i] = y[pivots[i]]
            for c in range(rank):
                trapezoid[i, c] = L[i, c] if c <= i else 0.0
        least_squares(trapezoid, permuted)
        for k in range(rank):
            row[0, k] = permuted[k]
    for k in range(rank - 1, -1, -1):
        reflect(reflectors, k, row, 0)


@compiled
def least_squares(M: np.ndarray, y: np.ndarray) -> None:
    """Overwrite the first entries of y [r] with the x [n] that minimises |M x - y|; M is lost."""
    r, n = M.shape
    for k in range(n):
        square = 0.0
        for i in range(k, r):
            square += M[i, k] * M[i, k]
        length = math.sqrt(square)
        first = M[k, k]
        kept = -length if first >= 0.0 else length
        M[k, k] = first - kept
        scale = 1.0 / (length * (length + abs(first)))
        for c in range(k + 1, n):
            along = 0.0
            for i in range(k, r):
                along += M[i, k] * M[i, c]
            for i in range(k, r):
                M[i, c] -= along * scale * M[i, k]
        along = 0.0
        for i in range(k, r):
            along += M[i, k] * y[i]
        for i in range(k, r):
            y[i] -= along * scale * M[i, k]
        M[k, k] = kept
    for k in range(n - 1, -1, -1):
        for c in range(k + 1, n):
            y[k] -= M[k, c] * y[c]
        y[k] /= M[k, k]


@entrance
def factorise_alone(
    J: np.ndarray, L: np.ndarray, reflectors: np.ndarray, pivots: np.ndarray, tolerance: float
) -> int:
    """Factorise J, called from Python."""
    return factorise(J, L, reflectors, pivots, tolerance)


@entrance
def project_alone(reflectors: np.ndarray, rank: int, x: np.ndarray, out: np.ndarray) -> None:
    """Project x, called from Python."""
    project(reflectors, rank, x, out)


@entrance
def lift_alone(
    L: np.ndarray, reflectors: np.ndarray, pivots: np.ndarray, rank: int, y: np.ndarray,
    out: np.ndarray,
) -> None:  # fmt: skip
    """Lift y, called from Python."""
    lift(L, reflectors, pivots, rank, y, out)
