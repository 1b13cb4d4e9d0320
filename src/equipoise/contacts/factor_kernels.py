"""Kernels of the pivoted orthogonal factorisation of contact rows: its projector, its inverse.

`J[pivots] = L Q1^T` with L lower trapezoidal (r, rank) and Q1 (nv, rank) orthonormal, kept as
reflectors: row k of `reflectors` is a vector u of length sqrt(2), zero before column k, and Q1 is
the first columns of the product of all `I - u u^T`.
"""

from __future__ import annotations

import math

import numpy as np

from equipoise.compilation import compiled, entrance, inlined


@entrance
def factorise(
    J: np.ndarray, L: np.ndarray, reflectors: np.ndarray, pivots: np.ndarray, tolerance: float
) -> int:
    """Factorise J [r, nv]; return the rank: rows beyond have less than `tolerance` of the first."""
    r, nv = J.shape
    squares = np.empty(r)
    for i in range(r):
        pivots[i] = i
        total = 0.0
        for c in range(nv):
            L[i, c] = J[i, c]
            total += J[i, c] * J[i, c]
        squares[i] = total
    largest = 0.0
    for k in range(min(r, nv)):
        best = k
        for i in range(k + 1, r):
            if squares[i] > squares[best]:
                best = i
        length = math.sqrt(squares[best])
        if k == 0:
            largest = length
        if not length > tolerance * largest:
            return k
        if best != k:
            pivots[k], pivots[best] = pivots[best], pivots[k]
            squares[best] = squares[k]
            for c in range(nv):
                L[k, c], L[best, c] = L[best, c], L[k, c]
        u = reflectors[k]
        first = L[k, k]
        kept = -length if first >= 0.0 else length
        scale = 1.0 / math.sqrt(length * (length + abs(first)))
        for c in range(k):
            u[c] = 0.0
        for c in range(k, nv):
            u[c] = L[k, c] * scale
        u[k] = (first - kept) * scale
        L[k, k] = kept
        for i in range(k + 1, r):
            row = L[i]
            reflect(u, row, k)
            total = 0.0
            for c in range(k + 1, nv):
                total += row[c] * row[c]
            squares[i] = total
    return min(r, nv)


@inlined
def reflect(u: np.ndarray, x: np.ndarray, start: int) -> None:
    """Apply `I - u u^T` to x, where u is zero before `start`."""
    along = 0.0
    for c in range(start, x.shape[0]):
        along += x[c] * u[c]
    for c in range(start, x.shape[0]):
        x[c] -= along * u[c]


@entrance
def project(reflectors: np.ndarray, rank: int, x: np.ndarray, out: np.ndarray) -> None:
    """Write `x - Q1 Q1^T x` to `out`."""
    for c in range(x.shape[0]):
        out[c] = x[c]
    for k in range(rank):
        reflect(reflectors[k], out, k)
    for k in range(rank):
        out[k] = 0.0
    for k in range(rank - 1, -1, -1):
        reflect(reflectors[k], out, k)


@entrance
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
    for c in range(out.shape[0]):
        out[c] = 0.0
    if rank == r:
        for k in range(r):
            total = y[pivots[k]]
            for c in range(k):
                total -= L[k, c] * out[c]
            out[k] = total / L[k, k]
    else:
        permuted = np.empty(r)
        for i in range(r):
            permuted[i] = y[pivots[i]]
        trapezoid = L[:, :rank].copy()
        for i in range(rank):
            for c in range(i + 1, rank):
                trapezoid[i, c] = 0.0
        least_squares(trapezoid, permuted)
        for k in range(rank):
            out[k] = permuted[k]
    for k in range(rank - 1, -1, -1):
        reflect(reflectors[k], out, k)


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
