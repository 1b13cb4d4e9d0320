"""Underactuation: the wrench that has no motor is handed to the supporting contacts.

`S^T tau = u - J_r^T F`, with `F` such that the base rows vanish: the motion stays that of the fully
actuated law, the reaction of the supporting contacts changes by `F`. Geometry only.
"""

from __future__ import annotations

import math

import numpy as np

from equipoise.compiled import compiled, entrance, scratch, scratch_matrix
from equipoise.spatial import Array

LIGHTEST = 0.05  # share of the mean load below which a foot counts as no lighter


def distribute_base_wrench(u_base: Array, J_base: Array, costs: Array, lam_without: Array) -> Array:
    """Return `F` (k,) with `J_base^T F = u_base`, making the reaction as easy as possible.

    Args: `u_base` (b,) base rows of the law; `J_base` (k, b) base columns of the supporting rows;
    `costs` (k,) > 0 of each component; `lam_without` (k,) the reaction that would act with
    F = 0, as predicted from the last measured one: `lam_meas - F_previous`. Among all F the one
    returned minimises `sum (costs * (lam_without + F))^2`.
    Source: theory of underactuation, after eq. (24); the print puts torque on the base rows.
    """
    J = np.ascontiguousarray(J_base, dtype=float)
    F = np.empty(len(costs))
    least_alone(J, np.arange(len(costs)), u_base, costs, lam_without, F)
    return F


@compiled
def least_reaction(
    J: np.ndarray,
    rows: np.ndarray,
    u: np.ndarray,
    costs: np.ndarray,
    lam_without: np.ndarray,
    base: int,
    F: np.ndarray,
) -> None:
    """Write the F [k] of `distribute_base_wrench`; J [r, nv] has the supporting rows at `rows`.

    The first `base` entries of u are those without a motor.
    """
    normal, wanted = scratch_matrix(base, base), scratch(base)
    normal[:, :] = 0.0
    for i in range(base):
        wanted[i] = u[i]
    for k in range(rows.shape[0]):
        weight = 1.0 / (costs[k] * costs[k])
        for i in range(base):
            wanted[i] += J[rows[k], i] * lam_without[k]
            for m in range(base):
                normal[i, m] += weight * J[rows[k], i] * J[rows[k], m]
    solve_in_place(normal, wanted)
    for k in range(rows.shape[0]):
        total = 0.0
        for i in range(base):
            total += J[rows[k], i] * wanted[i]
        F[k] = total / (costs[k] * costs[k]) - lam_without[k]


@compiled
def measured_loads(lam: np.ndarray, normal_rows: np.ndarray, loads: np.ndarray) -> None:
    """Write the load [n] of each support that was last measured, as a multiple of the mean.

    Support i has its compression in lam[normal_rows[i]] (-1: none, it counts as unloaded).
    """
    count, mean = normal_rows.shape[0], 0.0
    for i in range(count):
        loads[i] = max(lam[normal_rows[i]], 0.0) if normal_rows[i] >= 0 else 0.0
        mean += loads[i] / count
    for i in range(count):
        loads[i] = min(max(loads[i] / mean, LIGHTEST), 1.0 / LIGHTEST) if mean > 0.0 else 1.0


@compiled
def reaction_costs(
    loads: np.ndarray, ends: np.ndarray, terms: np.ndarray, split: bool, costs: np.ndarray
) -> None:
    """Write the costs [k] of the supporting rows at loads [n].

    Support i has the rows up to ends[i]; `terms` [2, k] holds for each row the constant part of its
    cost and the part over the load. Where the load is `split`, the constant part is over its root:
    then the cheapest normal forces are in the ratio of the loads.
    """
    start = 0
    for i in range(ends.shape[0]):
        root = math.sqrt(loads[i]) if split else 1.0
        for k in range(start, ends[i]):
            costs[k] = terms[0, k] / root + terms[1, k] / loads[i]
        start = ends[i]


@compiled
def solve_in_place(M: np.ndarray, b: np.ndarray) -> None:
    """Overwrite b [n] with the solution of M x = b by elimination with pivots; M is lost."""
    n = b.shape[0]
    for k in range(n):
        p = k
        for i in range(k + 1, n):
            if abs(M[i, k]) > abs(M[p, k]):
                p = i
        if p != k:
            b[k], b[p] = b[p], b[k]
            for c in range(n):
                M[k, c], M[p, c] = M[p, c], M[k, c]
        for i in range(k + 1, n):
            factor = M[i, k] / M[k, k]
            b[i] -= factor * b[k]
            for c in range(k + 1, n):
                M[i, c] -= factor * M[k, c]
    for k in range(n - 1, -1, -1):
        for c in range(k + 1, n):
            b[k] -= M[k, c] * b[c]
        b[k] /= M[k, k]


@entrance
def least_alone(
    J: np.ndarray, rows: np.ndarray, u: np.ndarray, costs: np.ndarray, lam_without: np.ndarray,
    F: np.ndarray,
) -> None:  # fmt: skip
    """Share out one wrench, called from Python."""
    least_reaction(J, rows, u, costs, lam_without, u.shape[0], F)
