"""Kernels of the law: the extended error (21), the force (24), and what becomes of its base rows.

No inertia, no gravity, no Coriolis term: errors, contact rows and constant gains.
"""

from __future__ import annotations

import math

import numpy as np

from equipoise.compiled.compilation import compiled, entrance
from equipoise.compiled.scratch import scratch
from equipoise.contacts.factor import factorise, lift, project
from equipoise.control.base_wrench.least import least_reaction, reaction_costs
from equipoise.control.passivity.manifold_kernels import (
    RATE_OF_S_DF,
    S_P0,
    S_QF,
    S_QP,
    S_RF,
    S_RP,
    force_integrate,
    force_update,
    posture_integrate,
    posture_update,
)
from equipoise.spatial.kernels import crossed, turned, turned_back

RUN, SATURATED, HELD = range(3)  # how a tick went
WHOLE, WANTED, REACTED = range(3)  # parts of a tick, see `law_tick`


@compiled
def base_pose(q: np.ndarray, T: np.ndarray) -> None:
    """Write the pose row of the base of q [nq]; its quaternion xyzw may be off unit length."""
    x, y, z, w = q[3], q[4], q[5], q[6]
    two = 2.0 / (x * x + y * y + z * z + w * w)
    T[0], T[1], T[2] = 1.0 - two * (y * y + z * z), two * (x * y + w * z), two * (x * z - w * y)
    T[3], T[4], T[5] = two * (x * y - w * z), 1.0 - two * (x * x + z * z), two * (y * z + w * x)
    T[6], T[7], T[8] = two * (x * z + w * y), two * (y * z - w * x), 1.0 - two * (x * x + y * y)
    T[9], T[10], T[11] = q[0], q[1], q[2]


@compiled
def velocity_error(
    q: np.ndarray, v: np.ndarray, q_ref: np.ndarray, v_ref: np.ndarray, dv: np.ndarray
) -> None:
    """Write `v - Ad v_ref`: the wanted twist of the base is seen from the actual base first."""
    base, ref = scratch(12), scratch(12)
    base_pose(q, base)
    base_pose(q_ref, ref)
    vx, vy, vz = turned(ref, v_ref[0], v_ref[1], v_ref[2])
    wx, wy, wz = turned(ref, v_ref[3], v_ref[4], v_ref[5])
    px, py, pz = ref[9] - base[9], ref[10] - base[10], ref[11] - base[11]
    cx, cy, cz = crossed(px, py, pz, wx, wy, wz)
    vx, vy, vz = turned_back(base, vx + cx, vy + cy, vz + cz)
    wx, wy, wz = turned_back(base, wx, wy, wz)
    dv[0], dv[1], dv[2] = v[0] - vx, v[1] - vy, v[2] - vz
    dv[3], dv[4], dv[5] = v[3] - wx, v[4] - wy, v[5] - wz
    for i in range(6, v.shape[0]):
        dv[i] = v[i] - v_ref[i]


@compiled
def is_finite(x: np.ndarray) -> bool:
    """Tell whether no entry is NaN or infinite; isfinite() would not notice, see `soundness`."""
    total = 0.0
    for i in range(x.shape[0]):
        total += x[i]
    return abs(total) < np.inf


@compiled
def law_force(
    q: np.ndarray,
    v: np.ndarray,
    q_ref: np.ndarray,
    v_ref: np.ndarray,
    dq: np.ndarray,
    lam_ref: np.ndarray,
    J: np.ndarray,
    L: np.ndarray,
    reflectors: np.ndarray,
    pivots: np.ndarray,
    regulated: np.ndarray,
    K_d: np.ndarray,
    posture: np.ndarray,
    force: np.ndarray,
    s: np.ndarray,
    u: np.ndarray,
    starting: bool,
    age: float,
    alpha: float,
    beta_p: float,
    k_ip: float,
    age_F: float,
    beta_F: float,
    k_iF: float,
    beta: float,
    mu: float,
    eta: float,
    tolerance: float,
    damp_violation: bool,
) -> int:
    """Write the extended error s [nv] and the force u [nv]; return the rank of J [r, nv].

    Source: eqs. (21), (24). Differs from the print: see `PassivityController`.
    """
    nv, r = v.shape[0], J.shape[0]
    rank = factorise(J, L, reflectors, pivots, tolerance)
    dv = scratch(nv)
    velocity_error(q, v, q_ref, v_ref, dv)
    if starting:
        for i in range(nv):
            posture[S_P0, i] = dv[i] + alpha * dq[i]
    posture_update(posture, dq, dv, age, alpha, beta_p, k_ip)
    force_update(force, age_F, beta_F, k_iF)
    s_rF, lifted = scratch(r), scratch(nv)
    s_rF[:] = 0.0
    for i in range(regulated.shape[0]):
        s_rF[regulated[i]] = force[S_RF, i]
    project(reflectors, rank, posture[S_RP], s)
    lift(L, reflectors, pivots, rank, s_rF, lifted)
    for i in range(nv):
        s[i] -= beta * lifted[i]
    if damp_violation:
        project(reflectors, rank, dv, lifted)
        for i in range(nv):
            s[i] += dv[i] - lifted[i]
    for i in range(nv):
        total = 0.0
        for k in range(nv):
            total += K_d[i, k] * s[k]
        u[i] = -total
    for i in range(regulated.shape[0]):
        along = (
            -lam_ref[i]
            - force[RATE_OF_S_DF, i]
            + k_iF * math.tanh(mu * force[S_QF, i])
            + eta * force[S_RF, i]
        )
        for k in range(nv):
            u[k] += J[regulated[i], k] * along
    return rank


@compiled
def law_torque(
    J: np.ndarray,
    reflectors: np.ndarray,
    rank: int,
    supporting: np.ndarray,
    regulated: np.ndarray,
    u: np.ndarray,
    base_reaction: np.ndarray,
    lam: np.ndarray,
    lam_ref: np.ndarray,
    tau_max: np.ndarray,
    posture: np.ndarray,
    force: np.ndarray,
    tau: np.ndarray,
    dt: float,
    bound: float,
    kind: int,
    layer: float,
    kind_F: int,
    layer_F: float,
) -> int:
    """Write the torque tau [na] within its limits, advance the integrals, return how it went.

    The integral of a joint whose torque is clamped stops if it would push further. If the torque
    is not finite nothing is written and HELD returned.
    """
    nv, na = u.shape[0], tau.shape[0]
    wanted = scratch(na)
    for k in range(na):
        wanted[k] = u[6 + k]
    for i in range(supporting.shape[0]):
        for k in range(na):
            wanted[k] -= J[supporting[i], 6 + k] * base_reaction[i]
    if not is_finite(wanted):
        return HELD
    s_qp, held = scratch(nv), scratch(nv)
    held[:] = 0.0
    project(reflectors, rank, posture[S_QP], s_qp)
    status = RUN
    for k in range(na):
        tau[k] = min(max(wanted[k], -tau_max[k]), tau_max[k])
        # K_d s enters the torque with a minus: a clamp at the top holds negative signs
        if (wanted[k] > tau[k] and s_qp[6 + k] < 0.0) or (wanted[k] < tau[k] and s_qp[6 + k] > 0.0):
            held[6 + k] = 1.0
        if wanted[k] != tau[k]:
            status = SATURATED
    posture_integrate(posture, s_qp, held, dt, bound, kind, layer)
    dlam = scratch(regulated.shape[0])
    for i in range(regulated.shape[0]):
        dlam[i] = lam[regulated[i]] - lam_ref[i]
    force_integrate(force, dlam, dt, kind_F, layer_F)
    return status


@entrance
def law_tick(
    q: np.ndarray,
    v: np.ndarray,
    lam: np.ndarray,
    q_ref: np.ndarray,
    v_ref: np.ndarray,
    lam_ref: np.ndarray,
    dq: np.ndarray,
    J: np.ndarray,
    L: np.ndarray,
    reflectors: np.ndarray,
    pivots: np.ndarray,
    regulated: np.ndarray,
    supporting: np.ndarray,
    normal_rows: np.ndarray,
    ends: np.ndarray,
    terms: np.ndarray,
    K_d: np.ndarray,
    tau_max: np.ndarray,
    posture: np.ndarray,
    force: np.ndarray,
    reaction_before: np.ndarray,
    u_before: np.ndarray,
    handover: np.ndarray,
    s: np.ndarray,
    u: np.ndarray,
    reaction: np.ndarray,
    tau: np.ndarray,
    starting: bool,
    switching: bool,
    share: float,
    age: float,
    alpha: float,
    beta_p: float,
    k_ip: float,
    bound: float,
    kind: int,
    layer: float,
    age_F: float,
    beta_F: float,
    k_iF: float,
    kind_F: int,
    layer_F: float,
    beta: float,
    mu: float,
    eta: float,
    damp_violation: bool,
    tolerance: float,
    dt: float,
    part: int,
    rank: int,
) -> tuple[int, int]:
    """Write s, u [nv], the reaction [k] and tau [na]; return how the tick went and the rank of J.

    When `switching`, `handover` [nv] becomes what u would jump by; a `share` of it is added to u.
    One call for all: calling a kernel from Python costs about as much as half of these. Only where
    somebody else shares out the base wrench there are two: WANTED stops at u, REACTED goes on with
    the reaction that was found, and the `rank`.
    """
    if part != REACTED:
        if not (is_finite(lam) and is_finite(q_ref) and is_finite(v_ref) and is_finite(lam_ref)):
            return HELD, 0
        rank = law_force(
            q, v, q_ref, v_ref, dq, lam_ref, J, L, reflectors, pivots, regulated, K_d, posture,
            force, s, u, starting, age, alpha, beta_p, k_ip, age_F, beta_F, k_iF, beta, mu, eta,
            tolerance, damp_violation,
        )  # fmt: skip
        for i in range(u.shape[0]):
            if switching:
                handover[i] = u_before[i] - u[i]
            u[i] += share * handover[i]
    if part == WANTED:
        return RUN if is_finite(u) else HELD, rank
    if part == WHOLE:
        count = supporting.shape[0]
        costs, without = scratch(count), scratch(count)
        reaction_costs(lam, normal_rows, ends, terms, costs)
        for i in range(count):
            without[i] = lam[supporting[i]] - reaction_before[i]
        least_reaction(J, supporting, u, costs, without, reaction)
    how = law_torque(
        J, reflectors, rank, supporting, regulated, u, reaction, lam, lam_ref, tau_max, posture,
        force, tau, dt, bound, kind, layer, kind_F, layer_F,
    )  # fmt: skip
    return how, rank
