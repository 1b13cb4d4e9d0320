"""Kernels of equation (8): inertia and Delassus matrix factorised, multipliers, accelerations."""

from __future__ import annotations

import math

import numpy as np

from equipoise.compiled.compilation import compiled, entrance
from equipoise.compiled.scratch import scratch, scratch_matrix

column = np.uint64  # the compiler makes better loops of unsigned columns


@compiled
def cholesky(M: np.ndarray, L: np.ndarray) -> bool:
    """Write the lower L with L L^T = M [n, n], of which the lower half is read; False if none."""
    n = M.shape[0]
    for i in range(n):
        for k in range(i + 1):
            total = M[i, k]
            for c in range(column(k)):
                total -= L[i, c] * L[k, c]
            if i == k:
                if not total > 0.0:
                    return False
                L[i, i] = math.sqrt(total)
            else:
                L[i, k] = total / L[k, k]
    return True


@compiled
def forward(L: np.ndarray, b: np.ndarray, x: np.ndarray) -> None:
    """Write x = L^-1 b."""
    for k in range(b.shape[0]):
        total = b[k]
        for c in range(column(k)):
            total -= L[k, c] * x[c]
        x[k] = total / L[k, k]


@compiled
def backward(L: np.ndarray, x: np.ndarray) -> None:
    """Overwrite x by L^-T x."""
    for k in range(x.shape[0] - 1, -1, -1):
        x[k] /= L[k, k]
        for c in range(column(k)):
            x[c] -= L[k, c] * x[k]


@entrance
def reduce_to_contacts(
    M: np.ndarray,
    damping: np.ndarray,
    h: float,
    force: np.ndarray,
    bias: np.ndarray,
    v: np.ndarray,
    J: np.ndarray,
    rate: np.ndarray,
    phi: np.ndarray,
    drift: np.ndarray,
    position_gain: float,
    velocity_gain: float,
    L: np.ndarray,
    half: np.ndarray,
    half_free: np.ndarray,
    delassus: np.ndarray,
    slip_speed: np.ndarray,
    a_free: np.ndarray,
    rhs: np.ndarray,
) -> None:
    """Write what the contacts see of the robot, from M [nv, nv] (lower half), changed in place.

    L is the factor of M + h D; half [r, nv] = (L^-1 J^T)^T; half_free = L^-1 (force - bias - D v);
    delassus = J M^-1 J^T; slip_speed = J v - rate; a_free = J a without contact forces; and rhs,
    what the contact forces have to add to that, stabilised.
    """
    nv, r = M.shape[0], J.shape[0]
    free = scratch(nv)
    for i in range(nv):
        M[i, i] += h * damping[i]
        free[i] = force[i] - bias[i] - damping[i] * v[i]
    cholesky(M, L)
    forward(L, free, half_free)
    for i in range(r):
        forward(L, J[i], half[i])
        speed, acceleration = -rate[i], 0.0
        for c in range(column(nv)):
            speed += J[i, c] * v[c]
            acceleration += half[i, c] * half_free[c]
        slip_speed[i], a_free[i] = speed, acceleration
        rhs[i] = -drift[i] - position_gain * phi[i] - velocity_gain * speed - acceleration
        for k in range(i + 1):
            total = 0.0
            for c in range(column(nv)):
                total += half[i, c] * half[k, c]
            delassus[i, k] = delassus[k, i] = total


@entrance
def multipliers(
    delassus: np.ndarray,
    rhs: np.ndarray,
    active: np.ndarray,
    compliance: np.ndarray,
    proximal: float,
    kept: np.ndarray,
    lam: np.ndarray,
) -> bool:
    """Write lam [r] with (delassus + compliance) lam = rhs on the active rows, zero on the others.

    `kept` [r] are whole numbers to write to: the active rows.

    Redundant rows get a proximal term relative to the matrix, and one step of refinement. False if
    the matrix could not be factorised even so; then nothing is written.
    """
    r = rhs.shape[0]
    count = 0
    for i in range(r):
        if active[i]:
            kept[count] = i
            count += 1
    matrix, factor = scratch_matrix(count, count), scratch_matrix(count, count)
    wanted, x, more = scratch(count), scratch(count), scratch(count)
    trace = 0.0
    for i in range(count):
        wanted[i] = rhs[kept[i]]
        for k in range(count):
            matrix[i, k] = delassus[kept[i], kept[k]]
        matrix[i, i] += compliance[kept[i]]
        trace += matrix[i, i]
    scale = proximal * trace / max(count, 1)
    for i in range(count):
        matrix[i, i] += scale
    if not cholesky(matrix, factor):
        return False
    forward(factor, wanted, x)
    backward(factor, x)
    for i in range(count):
        total = wanted[i] + scale * x[i]  # the residual of the matrix without the term
        for k in range(count):
            total -= matrix[i, k] * x[k]
        more[i] = total
    for i in range(count):
        wanted[i] = more[i]
    forward(factor, wanted, more)
    backward(factor, more)
    lam[:] = 0.0
    for i in range(count):
        lam[kept[i]] = x[i] + more[i]
    return True


@entrance
def accelerations_of(
    L: np.ndarray, half: np.ndarray, half_free: np.ndarray, lam: np.ndarray, a: np.ndarray
) -> None:
    """Write `a = M^-1 (free + J^T lam)`."""
    for c in range(column(a.shape[0])):
        a[c] = half_free[c]
    for i in range(lam.shape[0]):
        for c in range(column(a.shape[0])):
            a[c] += half[i, c] * lam[i]
    backward(L, a)


@entrance
def largest_of(phi: np.ndarray, rows: np.ndarray) -> float:
    """Return the largest |phi| of some rows."""
    largest = 0.0
    for i in range(rows.shape[0]):
        largest = max(largest, abs(phi[rows[i]]))
    return largest
