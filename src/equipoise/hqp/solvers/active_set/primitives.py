"""Compiled primitives of the active-set solver: inner products, reflectors, small triangles.

Reflector j is a row u of length sqrt(2), zero before column j; it maps a row x to x - (x . u) u.
The product of reflectors 0, 1, ... is an orthonormal Q, and a row a has the coordinates a Q.

All kernels are plain Python, and run uncompiled under NUMBA_DISABLE_JIT=1. What speed asked for:
rows are addressed as (array, row number), since compiled code pays for views; inner loops run over
unsigned columns; one reflector goes over many rows rather than many over one, which would wait for
itself; reflectors begin at a multiple of four columns.
"""

from __future__ import annotations

import numpy as np

from equipoise.compiled.compilation import compiled, inlined

column = np.uint64


@inlined
def dot(x: np.ndarray, i: int, y: np.ndarray, j: int, start: int, stop: int) -> float:
    """Return x[i, start:stop] . y[j, start:stop]."""
    total = 0.0
    for c in range(column(start), column(stop)):
        total += x[i, c] * y[j, c]
    return total


@inlined
def dot_vector(x: np.ndarray, i: int, y: np.ndarray, start: int, stop: int) -> float:
    """Return x[i, start:stop] . y[start:stop]."""
    total = 0.0
    for c in range(column(start), column(stop)):
        total += x[i, c] * y[c]
    return total


@inlined
def length(x: np.ndarray, size: int) -> float:
    """Return the Euclidean norm of x[:size]."""
    total = 0.0
    for c in range(column(size)):
        total += x[c] * x[c]
    return np.sqrt(total)


@inlined
def reflect(x: np.ndarray, i: int, u: np.ndarray, j: int, stop: int) -> None:
    """Apply reflector j, zero from column `stop` on, to row i of x."""
    start = j - j % 4
    along = 0.0
    for c in range(column(start), column(stop)):
        along += x[i, c] * u[j, c]
    for c in range(column(start), column(stop)):
        x[i, c] -= along * u[j, c]


@inlined
def reflect_vector(x: np.ndarray, u: np.ndarray, j: int, stop: int) -> None:
    """Apply reflector j, zero from column `stop` on, to the vector x."""
    start = j - j % 4
    along = 0.0
    for c in range(column(start), column(stop)):
        along += x[c] * u[j, c]
    for c in range(column(start), column(stop)):
        x[c] -= along * u[j, c]


@compiled
def make_reflector(x: np.ndarray, i: int, u: np.ndarray, j: int, stop: int, norm: float) -> None:
    """Write to u[j] the reflector that leaves of x[i, j:stop] the first entry, and apply it.

    `norm` is that of x[i, j:stop].
    """
    first = x[i, j]
    kept = -norm if first >= 0.0 else norm
    scale = 1.0 / np.sqrt(norm * (norm + abs(first)))
    for c in range(column(j - j % 4), column(j)):
        u[j, c] = 0.0
    for c in range(column(j), column(stop)):
        u[j, c] = x[i, c] * scale
    u[j, j] = (first - kept) * scale
    x[i, j] = kept


@inlined
def copy_row(x: np.ndarray, i: int, y: np.ndarray, j: int, size: int) -> None:
    """Copy y[j, :size] to x[i, :size]."""
    for c in range(column(size)):
        x[i, c] = y[j, c]


@inlined
def copy_vector(x: np.ndarray, y: np.ndarray, size: int) -> None:
    """Copy y[:size] to x[:size]."""
    for c in range(column(size)):
        x[c] = y[c]


@compiled
def factorise(square: np.ndarray, size: int, least: float) -> bool:
    """Replace the lower half of a symmetric matrix by its Cholesky factor.

    The diagonal holds the inverses. Returns False where a pivot is not above `least`.
    """
    for i in range(size):
        for j in range(i):
            square[i, j] = (square[i, j] - dot(square, i, square, j, 0, j)) * square[j, j]
        pivot = square[i, i] - dot(square, i, square, i, 0, i)
        if not pivot > least:
            return False
        square[i, i] = 1.0 / np.sqrt(pivot)
    return True


@compiled
def solve_factorised(square: np.ndarray, x: np.ndarray, size: int) -> None:
    """Solve with the Cholesky factor that `factorise` left, in place."""
    for i in range(size):
        x[i] = (x[i] - dot_vector(square, i, x, 0, i)) * square[i, i]
    for i in range(size - 1, -1, -1):
        x[i] *= square[i, i]
        for k in range(column(i)):
            x[k] -= square[i, k] * x[i]
