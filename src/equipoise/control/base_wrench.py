"""Underactuation: the wrench that has no motor is handed to the supporting contacts.

`S^T tau = u - J_r^T F`, with `F` such that the base rows vanish: the motion stays that of the fully
actuated law, the reaction of the supporting contacts changes by `F`. Geometry only.
"""

from __future__ import annotations

import numpy as np

from equipoise.spatial import Array


def distribute_base_wrench(u_base: Array, J_base: Array, costs: Array, lam_without: Array) -> Array:
    """Return `F` (k,) with `J_base^T F = u_base`, making the reaction as easy as possible.

    Args: `u_base` (6,) base rows of the law; `J_base` (k, 6) base columns of the supporting rows;
    `costs` (k,) > 0 of each component; `lam_without` (k,) the reaction that would act with
    F = 0, as predicted from the last measured one: `lam_meas - F_previous`. Among all F the one
    returned minimises `sum (costs * (lam_without + F))^2`.
    Source: theory of underactuation, after eq. (24); the print puts torque on the base rows.
    """
    G = J_base.T
    inverse_squares = 1.0 / (costs * costs)
    GW = G * inverse_squares
    wanted = u_base + G @ lam_without
    multiplier = np.linalg.solve(GW @ G.T, wanted)
    return GW.T @ multiplier - lam_without
