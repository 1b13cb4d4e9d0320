"""Kernel of the map at a switch of supports: what the torque carried goes over to other contacts.

`w` is what the torque must keep: `S^T tau`, plus `J_lost^T lam_lost` of lost contacts where the
energy is to be kept. Where a contact goes the noise of tau is left out of it: it would stay in the
integral. Where one comes that may be an impact, and all of it counts. With `u_0` what the law would
say with an empty integral, s+ and F+ solve

    K_d s+ + J_r^T F+ = u_0 - w,    J s+ = 0,

in the rows of the new contacts: s+ is K_d^-1 (u_0 - w) without what violates a contact, in the
metric of K_d. The integral becomes `s+ / k_ip`. What is left along rows of hands neither of them
can carry: the hand-over does. Derived on the page docs/switching.md.
"""

from __future__ import annotations

import numpy as np

from equipoise.compiled import compiled, scratch
from equipoise.compiled.workspace import Block, integers, matrix, vector
from equipoise.contacts.factor import reflect
from equipoise.contacts.stack import RANK_TOLERANCE
from equipoise.control.passivity.manifold_kernels import INTEGRAL
from equipoise.control.passivity.memory import (
    BOUND,
    CARRIED,
    CLOCK,
    FLAGS,
    FOUND,
    GAINS,
    J_PHI,
    K_IP,
    L_FACTOR,
    LAM,
    LIFTED,
    MAPPING,
    OBSERVING,
    PIVOTS,
    POSTURE,
    REACTION,
    REFLECTORS,
    ROW_COUNT,
    SUPPORTING,
    SUPPORTING_COUNT,
    SWITCHING,
    T_SUPPORTS,
    TAU,
    TAU_SLOW,
    U_BEFORE,
    UNROOT,
    U,
    leading,
    leading_rows,
    leading_whole,
)
from equipoise.control.passivity.nearest_kernels import factorise_in_metric


@compiled
def map_supports(law: Block, base: int, t: float) -> None:
    """Write integral, F+ and what u was, for the u_0 that stands in the law's u.

    `base` is the number of entries without a motor. The factors of J are those in the metric of K_d
    afterwards.
    """
    flags, gains = integers(law, FLAGS), vector(law, GAINS)
    r = flags[ROW_COUNT]
    J, L = leading_rows(law, J_PHI, r), leading_rows(law, L_FACTOR, r)
    reflectors, pivots = leading_rows(law, REFLECTORS, r), leading_whole(law, PIVOTS, r)
    unroot = matrix(law, UNROOT)
    rank = factorise_in_metric(J, unroot, L, reflectors, pivots, RANK_TOLERANCE)
    u, tau, before = vector(law, U), vector(law, TAU), vector(law, U_BEFORE)
    if flags[MAPPING] == LIFTED:
        tau = vector(law, TAU_SLOW)
    carried, integral = vector(law, CARRIED), matrix(law, POSTURE)[INTEGRAL]
    nv = u.shape[0]
    for i in range(nv):
        before[i] = carried[i]
        if i >= base:
            before[i] += tau[i - base]
        carried[i] = 0.0
    z = scratch(nv)
    split_force(unroot, reflectors, rank, u, before, z)
    G = scratch(r)
    forces_of(L, pivots, rank, z, G)
    tangent = scratch(nv)
    velocity_of(unroot, reflectors, rank, z, tangent)
    for i in range(nv):
        integral[i] = 0.0
        if gains[K_IP] > 0.0:
            integral[i] = min(max(tangent[i] / gains[K_IP], -gains[BOUND]), gains[BOUND])
    count = flags[SUPPORTING_COUNT]
    F, found, lam = leading(law, REACTION, count), leading(law, FOUND, count), vector(law, LAM)
    supporting = leading_whole(law, SUPPORTING, count)
    for i in range(count):
        F[i], found[i] = G[supporting[i]], lam[supporting[i]]
        for c in range(nv):
            before[c] += J[supporting[i], c] * F[i]
    flags[MAPPING], flags[SWITCHING], flags[OBSERVING] = 0, 1, 0
    vector(law, CLOCK)[T_SUPPORTS] = t


@compiled
def split_force(
    unroot: np.ndarray, reflectors: np.ndarray, rank: int, u: np.ndarray, w: np.ndarray,
    z: np.ndarray,
) -> None:  # fmt: skip
    """Write `Q^T U^-1 (u - w)` [nv]: the contacts bear its first `rank` entries, K_d the rest."""
    nv = u.shape[0]
    row = z.reshape(1, -1)
    for i in range(nv):
        total = 0.0
        for k in range(i, nv):
            total += unroot[k, i] * (u[k] - w[k])
        z[i] = total
    for k in range(rank):
        reflect(reflectors, k, row, 0)


@compiled
def forces_of(L: np.ndarray, pivots: np.ndarray, rank: int, z: np.ndarray, G: np.ndarray) -> None:
    """Write the multipliers G [r] that bear the first `rank` entries of z; dependent rows get 0."""
    G[:] = 0.0
    for k in range(rank - 1, -1, -1):
        total = z[k]
        for i in range(k + 1, rank):
            total -= L[i, k] * G[pivots[i]]
        G[pivots[k]] = total / L[k, k]


@compiled
def velocity_of(
    unroot: np.ndarray, reflectors: np.ndarray, rank: int, z: np.ndarray, out: np.ndarray
) -> None:
    """Write the s+ [nv] whose damping bears the entries of z from `rank` on."""
    nv = z.shape[0]
    kept = scratch(nv)
    row = kept.reshape(1, -1)
    for i in range(nv):
        kept[i] = z[i] if i >= rank else 0.0
    for k in range(rank - 1, -1, -1):
        reflect(reflectors, k, row, 0)
    for i in range(nv):
        total = 0.0
        for k in range(i + 1):
            total += unroot[i, k] * kept[k]
        out[i] = total
