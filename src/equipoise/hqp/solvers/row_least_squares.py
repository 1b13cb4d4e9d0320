"""Least squares of rows of very different lengths, each to the precision of its own length.

The independent rows are taken one after the other, the largest remainder first: M = [L1; L2] Q with
orthonormal rows Q. With T = L2 L1^-1 and the violations w1 = L1 y - r1, w2 = L2 y - r2, the least
|w1|^2 + |w2|^2 has (I + T^T T) w1 = -T^T (T r1 - r2) and w1 = -T^T w2.

Source: Peters and Wilkinson (1970).
"""

from __future__ import annotations

import numpy as np

DEPENDENT = 1e-8
MET_TOLERANCE = 1e-8
ROUNDING = 1e-14


def solve_rows(
    M: np.ndarray, target: np.ndarray, norms: np.ndarray, size: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the least y that brings M [m, k] y nearest to a target [m], with w = M y - target [m].

    `norms` [m] are the lengths of the rows before they were projected, `size` that of the unknowns
    to which y is added. Where all rows are met, w is zero. The third is how far w is rounding [m].
    """
    first, Q = _independent(M, norms)
    others = np.setdiff1d(np.arange(len(M)), first)
    w, rounding = np.zeros(len(M)), np.zeros(len(M))
    L1, L2 = M[first] @ Q.T, M[others] @ Q.T
    y = forward(L1, target[first]) if len(first) else np.zeros(0)
    size = max(size, float(np.linalg.norm(y)))
    w[others] = L2 @ y - target[others]
    if (np.abs(w) <= MET_TOLERANCE * norms * size).all():
        return Q.T @ y, np.zeros(len(M)), rounding
    if len(first):
        inverse = forward(L1, np.eye(len(first)))
        T = L2 @ inverse
        w1 = np.linalg.solve(np.eye(len(first)) + T.T @ T, -T.T @ w[others])
        w[others] += T @ w1
        w[first] = -T.T @ w[others]
        y = forward(L1, target[first] + w[first])
        pulled = ROUNDING * float(norms[others] @ np.abs(w[others]))
        rounding[first] = pulled * np.linalg.norm(inverse, axis=0)
        of_rows = ROUNDING * norms[first] * size + rounding[first]
        rounding[others] = ROUNDING * np.abs(w[others]) + np.abs(T) @ of_rows
        rounding[others] += ROUNDING * norms[others] * size
        rounding[first] += np.abs(T).T @ rounding[others]
    return Q.T @ y, w, rounding


def forward(L: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return x with `L x = b`, L lower triangular, row after row: each to its own length."""
    x = np.array(b, dtype=float)
    for i in range(len(L)):
        x[i] = (x[i] - L[i, :i] @ x[:i]) / L[i, i]
    return x


def _independent(M: np.ndarray, norms: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the numbers of independent rows, largest remainder first, and Q [r, k]."""
    rest, basis = M.copy(), np.empty((0, M.shape[1]))
    chosen: list[int] = []
    while len(chosen) < min(M.shape):
        left = np.linalg.norm(rest, axis=1)
        left[~(left > DEPENDENT * norms)] = 0.0
        row = int(np.argmax(left))
        if left[row] == 0.0:
            break
        along = rest[row] / left[row]
        along -= basis.T @ (basis @ along)  # what rounding has left of the others
        along /= np.linalg.norm(along)
        rest -= np.outer(rest @ along, along)
        rest[row] = 0.0
        basis = np.vstack([basis, along])
        chosen.append(row)
    return np.array(chosen, dtype=int), basis
