"""Kernels of the law: the extended error (21), the force (24), and what becomes of its base rows.

No inertia, no gravity, no Coriolis term: errors, contact rows and constant gains.
"""

from __future__ import annotations

import math

import numpy as np

from equipoise.compiled import compiled, scratch
from equipoise.compiled.workspace import Block, integers, matrix, matrix_at, vector
from equipoise.contacts.factor import factorise, lift, project
from equipoise.contacts.program import contact_rows, move_surfaces
from equipoise.contacts.stack import RANK_TOLERANCE
from equipoise.control.base_wrench.bounded_kernels import bounded_reaction
from equipoise.control.base_wrench.least import least_reaction, measured_loads, reaction_costs
from equipoise.control.base_wrench.shares import loads_from_zmp, pressed_middles
from equipoise.control.passivity.manifold_kernels import (
    INTEGRAL,
    RATE_OF_S_DF,
    S_F,
    S_F0,
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
from equipoise.control.passivity.memory import (
    ADAPT,
    ALPHA,
    AT,
    BETA,
    BETA_F,
    BETA_P,
    BOUND,
    BOUNDED,
    BY_ZMP,
    CENTRES,
    CLOCK,
    COSTS,
    DAMP_VIOLATION,
    DQ,
    DV,
    ENDS,
    ETA,
    FADE,
    FLAGS,
    FORCE,
    FOUND,
    GAINS,
    GROWTH_MAX,
    HANDING_OVER,
    HANDOVER,
    IN_METRIC,
    J_PHI,
    K_D,
    K_IF,
    K_IP,
    KIND_F,
    KIND_P,
    L_FACTOR,
    LAM,
    LAM_0,
    LAM_REF,
    LAYER_F,
    LAYER_P,
    LIFTED,
    LOADS,
    MAPPING,
    MU,
    NORMAL_ROWS,
    OBSERVER,
    OBSERVING,
    PERIOD,
    PIVOTS,
    POSTURE,
    Q_REF,
    RANK,
    REACTION,
    REFLECTORS,
    REGULATED,
    REGULATED_COUNT,
    RELAX,
    ROOT,
    ROW_COUNT,
    S_SLOW,
    SETTLES,
    SPLIT,
    STARTED,
    SUPPORT_COUNT,
    SUPPORTING,
    SUPPORTING_COUNT,
    SWITCHING,
    T_FORCE,
    T_HANDOVER,
    T_POSTURE,
    T_SUPPORTS,
    TAU,
    TAU_MAX,
    TAU_SLOW,
    TERMS,
    U_BEFORE,
    UNROOT,
    V_REF,
    WAITING,
    S,
    U,
    leading,
    leading_rows,
    leading_whole,
    packed,
)
from equipoise.control.passivity.nearest_kernels import factorise_in_metric, move_to_nearest
from equipoise.control.passivity.switch import map_supports
from equipoise.kinematics.kernels import VELOCITY, Q, is_finite, place_frames, place_joints
from equipoise.kinematics.manifold import difference, velocity_difference
from equipoise.kinematics.tree import base_size

RUN, SATURATED, HELD = range(3)  # how a tick went

NOISE_TIME = 0.005  # [s] of the low pass behind which torque and s_p are without noise
NOISE_FADES = 0.003  # [s] in which the noise of the torque at a switch fades
HELD_BACK = 0.9  # share of an integral's growth that stops while the targets wait for the robot


@compiled
def law_begin(tree: Block, state: Block, contacts: Block, t: float) -> bool:
    """Place joints and frames at the measured state, move surfaces; False if it is not finite."""
    if not (is_finite(vector(state, Q)) and is_finite(vector(state, VELOCITY))):
        return False
    place_joints(tree, state)
    place_frames(tree, state)
    move_surfaces(contacts, t)
    return True


@compiled
def inputs_are_finite(law: Block) -> bool:
    """Tell whether measured multipliers and the reference are finite."""
    rows, regulated = integers(law, FLAGS)[ROW_COUNT], integers(law, FLAGS)[REGULATED_COUNT]
    return (
        is_finite(leading(law, LAM, rows))
        and is_finite(vector(law, Q_REF))
        and is_finite(vector(law, V_REF))
        and is_finite(leading(law, LAM_REF, regulated))
    )


@compiled
def law_tick(
    tree: Block, state: Block, contacts: Block, law: Block, bounds: Block, rows: Block,
    search: Block, t: float,
) -> int:  # fmt: skip
    """Write s, u, the reaction and tau, advance the memory; return how it went.

    `state` is the measured one, placed; `bounds`, `rows`, `search` are of the bounded distribution.
    If something is not finite the memory stays as it was and HELD is returned.
    """
    if not inputs_are_finite(law):
        return HELD
    flags = integers(law, FLAGS)
    r, base = flags[ROW_COUNT], base_size(tree)
    J = leading_rows(law, J_PHI, r)
    clock, F, lam_0 = vector(law, CLOCK), vector(law, REACTION), vector(law, LAM_0)
    u, before, handed = vector(law, U), vector(law, U_BEFORE), vector(law, HANDOVER)
    kept_flags, kept_clock = scratch(flags.shape[0]), scratch(clock.shape[0])
    kept_F, kept_lam_0, kept_handed = (
        scratch(F.shape[0]), scratch(F.shape[0]), scratch(u.shape[0])
    )  # fmt: skip
    copy(F, kept_F)
    copy(lam_0, kept_lam_0)
    copy(handed, kept_handed)
    copy(clock, kept_clock)
    for i in range(flags.shape[0]):
        kept_flags[i] = flags[i]
    contact_rows(tree, state, contacts, J, integers(law, AT))
    rank = law_force(tree, state, law, J, t)
    observe(law)
    share_base_wrench(law, bounds, rows, search, J, base, t)
    how = law_torque(law, J, rank, base)
    if how == HELD:
        copy(kept_F, F)
        copy(kept_lam_0, lam_0)
        copy(kept_handed, handed)
        copy(kept_clock, clock)
        for i in range(flags.shape[0]):
            flags[i] = int(kept_flags[i])
        return HELD
    copy(u, before)
    tau, slow = vector(law, TAU), vector(law, TAU_SLOW)
    gain = slowness(vector(law, GAINS)) if flags[STARTED] else 1.0
    for i in range(tau.shape[0]):
        slow[i] += gain * (tau[i] - slow[i])
    flags[STARTED], flags[SWITCHING], flags[RANK] = 1, 0, rank
    return how


@compiled
def copy(x: np.ndarray, out: np.ndarray) -> None:
    """Copy x to `out`."""
    for i in range(x.shape[0]):
        out[i] = x[i]


@compiled
def observe(law: Block) -> None:
    """Follow the reaction that would act without our own part: see `ReactionObserver`.

    The measured multipliers of the supporting rows become what is observed plus our own part.
    """
    flags, gain = integers(law, FLAGS), vector(law, GAINS)[OBSERVER]
    if gain == 1.0:  # it shows what is measured
        return
    count = flags[SUPPORTING_COUNT]
    lam, lam_0, F = vector(law, LAM), vector(law, LAM_0), vector(law, REACTION)
    supporting = integers(law, SUPPORTING)
    for i in range(count):
        raw = lam[supporting[i]] - F[i]
        if not flags[OBSERVING]:
            lam_0[i] = raw
        lam_0[i] += gain * (raw - lam_0[i])
        lam[supporting[i]] = lam_0[i] + F[i]
    flags[OBSERVING] = 1


@compiled
def law_force(tree: Block, state: Block, law: Block, J: np.ndarray, t: float) -> int:
    """Write the extended error s [nv] and the force u [nv]; return the rank of J [r, nv].

    Source: eqs. (21), (24). Differs from the print: see `PassivityController`.
    """
    flags, gains, clock = integers(law, FLAGS), vector(law, GAINS), vector(law, CLOCK)
    count = flags[REGULATED_COUNT]
    rank = factorise_rows(law, J)
    dq, dv, nv = vector(law, DQ), vector(law, DV), J.shape[1]
    posture, force = matrix(law, POSTURE), packed(law, FORCE, 6, count)
    difference(tree, vector(law, Q_REF), vector(state, Q), dq)
    velocity_difference(
        tree, vector(state, Q), vector(state, VELOCITY), vector(law, Q_REF), vector(law, V_REF), dv
    )
    slow = vector(law, S_SLOW)
    for i in range(nv):
        s_p = dv[i] + gains[ALPHA] * dq[i]
        slow[i] += (slowness(gains) if flags[STARTED] else 1.0) * (s_p - slow[i])
    mapped, lifted = flags[MAPPING] != 0, flags[MAPPING] == LIFTED
    if not flags[STARTED] or mapped:
        clock[T_POSTURE] = t
        for i in range(nv):
            posture[S_P0, i] = dv[i] + gains[ALPHA] * dq[i]
    if not flags[STARTED]:
        clock[T_FORCE] = t
        for i in range(count):
            force[S_F0, i] = force[S_F, i]
    force_update(force, t - clock[T_FORCE], gains[BETA_F], gains[K_IF])
    if mapped:
        posture[INTEGRAL, :] = 0.0
        write_posture(law, 0.0)
        extended_force(law, J, rank)
        map_supports(law, base_size(tree), t)
        rank = factorise_rows(law, J)
        vector(law, SETTLES)[:] = 0.0
        if lifted:
            forget_noise(law, J, rank, t)
    write_posture(law, t - clock[T_POSTURE])
    extended_force(law, J, rank)
    if lifted:
        keep_noise(law, base_size(tree))
    hand_over(law, t)
    return rank


@compiled
def slowness(gains: np.ndarray) -> float:
    """Return the share of a tick by which what is without noise follows; all of it unfiltered."""
    return max(gains[OBSERVER], gains[PERIOD] / (gains[PERIOD] + NOISE_TIME))


@compiled
def forget_noise(law: Block, J: np.ndarray, rank: int, t: float) -> None:
    """Begin the hand-over and the posture's manifold at a switch from what is no noise.

    What is left of u goes to the hand-over as if s_p had its slow value; so far it `settles` there.
    """
    flags, clock = integers(law, FLAGS), vector(law, CLOCK)
    u, before, handed = vector(law, U), vector(law, U_BEFORE), vector(law, HANDOVER)
    slow, settles, posture = vector(law, S_SLOW), vector(law, SETTLES), matrix(law, POSTURE)
    write_posture(law, 0.0)
    extended_force(law, J, rank)
    clock[T_HANDOVER], flags[HANDING_OVER], flags[SWITCHING] = t, 1, 0
    for i in range(u.shape[0]):
        handed[i] = before[i] - u[i]
        settles[i] = u[i]
        posture[S_P0, i] = slow[i]


@compiled
def keep_noise(law: Block, base: int) -> None:
    """Write what noise was in the torque before a switch, over that which is in u now."""
    u, settles = vector(law, U), vector(law, SETTLES)
    tau, slow = vector(law, TAU), vector(law, TAU_SLOW)
    for i in range(u.shape[0]):
        settles[i] -= u[i]
        if i >= base:
            settles[i] += tau[i - base] - slow[i - base]


@compiled
def extended_force(law: Block, J: np.ndarray, rank: int) -> None:
    """Write s and u from both manifolds as they are now."""
    flags, gains = integers(law, FLAGS), vector(law, GAINS)
    r, count = flags[ROW_COUNT], flags[REGULATED_COUNT]
    regulated = leading_whole(law, REGULATED, count)
    dv, s, u = vector(law, DV), vector(law, S), vector(law, U)
    posture, force = matrix(law, POSTURE), packed(law, FORCE, 6, count)
    nv = u.shape[0]
    wanted = scratch(r)  # J s
    wanted[:] = 0.0
    if gains[IN_METRIC] != 0.0 and gains[DAMP_VIOLATION] != 0.0:
        violated_by_supports(law, J, dv, wanted)
    for i in range(count):
        wanted[regulated[i]] -= gains[BETA] * force[S_RF, i]
    split(law, J, rank, posture[S_RP], wanted, s)
    if gains[IN_METRIC] == 0.0 and gains[DAMP_VIOLATION] != 0.0:
        tangent = scratch(nv)
        keep_contacts(law, J, rank, dv, tangent)
        for i in range(nv):
            s[i] += dv[i] - tangent[i]
    K_d, lam_ref = matrix(law, K_D), vector(law, LAM_REF)
    for i in range(nv):
        total = 0.0
        for k in range(nv):
            total += K_d[i, k] * s[k]
        u[i] = -total
    for i in range(count):
        along = (
            -lam_ref[i]
            - force[RATE_OF_S_DF, i]
            + gains[K_IF] * math.tanh(gains[MU] * force[S_QF, i])
            + gains[ETA] * force[S_RF, i]
        )
        for k in range(nv):
            u[k] += J[regulated[i], k] * along


@compiled
def write_posture(law: Block, age: float) -> None:
    """Update the posture manifold at its age [s]."""
    gains = vector(law, GAINS)
    posture_update(
        matrix(law, POSTURE), vector(law, DQ), vector(law, DV), age, gains[ALPHA], gains[BETA_P],
        gains[K_IP], gains[ROOT], gains[LAYER_P],
    )  # fmt: skip


@compiled
def factorise_rows(law: Block, J: np.ndarray) -> int:
    """Factorise the contact rows J [r, nv] for the law's projector; return the rank."""
    r = J.shape[0]
    L, reflectors = leading_rows(law, L_FACTOR, r), leading_rows(law, REFLECTORS, r)
    pivots = leading_whole(law, PIVOTS, r)
    if vector(law, GAINS)[IN_METRIC] != 0.0:
        return factorise_in_metric(J, matrix(law, UNROOT), L, reflectors, pivots, RANK_TOLERANCE)
    return factorise(J, L, reflectors, pivots, RANK_TOLERANCE)


@compiled
def split(
    law: Block, J: np.ndarray, rank: int, x: np.ndarray, wanted: np.ndarray, out: np.ndarray
) -> None:
    """Write to `out` [nv] the part of x that violates no contact, plus a lift of `wanted` [r].

    Euclidean: `Q_phi x + J^+ wanted`; in the metric of K_d: `N x + J^# wanted`.
    """
    r, nv = J.shape
    L, reflectors = leading_rows(law, L_FACTOR, r), leading_rows(law, REFLECTORS, r)
    pivots = leading_whole(law, PIVOTS, r)
    if vector(law, GAINS)[IN_METRIC] != 0.0:
        copy(x, out)
        move_to_nearest(J, matrix(law, UNROOT), L, reflectors, pivots, rank, wanted, out)
        return
    lifted = scratch(nv)
    project(reflectors, rank, x, out)
    lift(L, reflectors, pivots, rank, wanted, lifted)
    for i in range(nv):
        out[i] += lifted[i]


@compiled
def keep_contacts(law: Block, J: np.ndarray, rank: int, x: np.ndarray, out: np.ndarray) -> None:
    """Write to `out` [nv] the part of x that violates no contact."""
    if vector(law, GAINS)[IN_METRIC] == 0.0:
        project(leading_rows(law, REFLECTORS, J.shape[0]), rank, x, out)
        return
    nothing = scratch(J.shape[0])
    nothing[:] = 0.0
    split(law, J, rank, x, nothing, out)


@compiled
def violated_by_supports(law: Block, J: np.ndarray, dv: np.ndarray, out: np.ndarray) -> None:
    """Write `J dv` of the supporting rows to `out` [r].

    Not of the regulated rows: their velocity error is noise of the force there.
    """
    count = integers(law, FLAGS)[SUPPORTING_COUNT]
    supporting = leading_whole(law, SUPPORTING, count)
    for i in range(count):
        row, total = supporting[i], 0.0
        for c in range(J.shape[1]):
            total += J[row, c] * dv[c]
        out[row] = total


@compiled
def hand_over(law: Block, t: float) -> None:
    """Add to u what is left of the difference that the last change of contacts would have made."""
    flags, clock, gains = integers(law, FLAGS), vector(law, CLOCK), vector(law, GAINS)
    u, before, difference_kept = vector(law, U), vector(law, U_BEFORE), vector(law, HANDOVER)
    if flags[SWITCHING]:
        clock[T_HANDOVER], flags[HANDING_OVER] = t, 1
        for i in range(u.shape[0]):
            difference_kept[i] = before[i] - u[i]
    if flags[HANDING_OVER]:
        share = math.exp(-(t - clock[T_HANDOVER]) / gains[FADE])
        for i in range(u.shape[0]):
            u[i] += share * difference_kept[i]
    settles, noise = vector(law, SETTLES), math.exp(-(t - clock[T_SUPPORTS]) / NOISE_FADES)
    for i in range(u.shape[0]):
        u[i] += noise * settles[i]


@compiled
def share_base_wrench(
    law: Block, bounds: Block, rows: Block, search: Block, J: np.ndarray, base: int, t: float
) -> None:
    """Write the reaction F that carries the base rows of u, least in cost or within bounds."""
    flags = integers(law, FLAGS)
    count = flags[SUPPORTING_COUNT]
    supporting = leading_whole(law, SUPPORTING, count)
    lam, u, F = vector(law, LAM), vector(law, U), leading(law, REACTION, count)
    without, wish, costs = scratch(count), scratch(count), leading(law, COSTS, count)
    left = math.exp(-(t - vector(law, CLOCK)[T_SUPPORTS]) / vector(law, GAINS)[RELAX])
    found = leading(law, FOUND, count)
    for i in range(count):
        without[i] = lam[supporting[i]] - F[i]
    if base == 0:
        F[:] = 0.0
        return
    support_costs(law, J, without, base, wish)
    for i in range(count):
        wish[i] += left * (found[i] - wish[i])
    if flags[BOUNDED]:
        bounded_reaction(
            bounds, rows, search, J, supporting, u, costs, without, wish, found, left,
            vector(law, TAU_MAX), base, t, F,
        )  # fmt: skip
        return
    for i in range(count):
        without[i] -= wish[i]
    least_reaction(J, supporting, u, costs, without, base, F)


@compiled
def support_costs(
    law: Block, J: np.ndarray, without: np.ndarray, base: int, wish: np.ndarray
) -> None:
    """Write what the supporting rows cost [k], and the reaction [k] that costs nothing.

    At the loads that are measured, and then nothing is free; or at those that the ZMP asks for.
    """
    flags, u = integers(law, FLAGS), vector(law, U)
    supports, count = flags[SUPPORT_COUNT], flags[SUPPORTING_COUNT]
    normal_rows, ends = (
        leading_whole(law, NORMAL_ROWS, supports),
        leading_whole(law, ENDS, supports),
    )
    loads, supporting = leading(law, LOADS, supports), leading_whole(law, SUPPORTING, count)
    split = flags[SPLIT] == BY_ZMP and base == 6
    if split:
        wrench = scratch(6)
        for i in range(6):
            wrench[i] = u[i]
            for k in range(count):
                wrench[i] += J[supporting[k], i] * without[k]
        centres = matrix_at(law.floats, law.table[CENTRES, 0], supports, 2)
        mean = loads_from_zmp(J, supporting, ends, normal_rows, centres, wrench, loads)
        pressed_middles(ends, normal_rows, centres, loads, mean, wish)
    else:
        wish[:] = 0.0
        measured_loads(vector(law, LAM), normal_rows, loads)
    costs, terms = leading(law, COSTS, count), packed(law, TERMS, 2, count)
    reaction_costs(loads, ends, terms, split, costs)


@compiled
def law_torque(law: Block, J: np.ndarray, rank: int, base: int) -> int:
    """Write the torque tau [na] within its limits, advance the integrals, return how it went.

    The integral of a joint whose torque is clamped stops if it would push further. If the torque
    is not finite nothing is written and HELD returned.
    """
    flags, gains = integers(law, FLAGS), vector(law, GAINS)
    count, supporting_count = flags[REGULATED_COUNT], flags[SUPPORTING_COUNT]
    regulated = leading_whole(law, REGULATED, count)
    supporting = leading_whole(law, SUPPORTING, supporting_count)
    u, tau, tau_max = vector(law, U), vector(law, TAU), vector(law, TAU_MAX)
    F, lam, lam_ref = vector(law, REACTION), vector(law, LAM), vector(law, LAM_REF)
    nv, na = u.shape[0], tau.shape[0]
    wanted = scratch(na)
    for k in range(na):
        wanted[k] = u[base + k]
    for i in range(supporting_count):
        for k in range(na):
            wanted[k] -= J[supporting[i], base + k] * F[i]
    if not is_finite(wanted):
        return HELD
    posture, force = matrix(law, POSTURE), packed(law, FORCE, 6, count)
    s_qp, held = scratch(nv), scratch(nv)
    held[:] = 0.0
    keep_contacts(law, J, rank, posture[S_QP], s_qp)
    status = RUN
    for k in range(na):
        tau[k] = min(max(wanted[k], -tau_max[k]), tau_max[k])
        # K_d s enters the torque with a minus: a clamp at the top holds negative signs
        if (wanted[k] > tau[k] and s_qp[base + k] < 0.0) or (
            wanted[k] < tau[k] and s_qp[base + k] > 0.0
        ):
            held[base + k] = 1.0
        if wanted[k] != tau[k]:
            status = SATURATED
    if flags[WAITING]:  # who is held back winds up ten times slower; who found a weight still can
        for i in range(nv):
            if s_qp[i] * posture[INTEGRAL, i] > 0.0:
                held[i] = max(held[i], HELD_BACK)
    posture_integrate(
        posture, s_qp, held, gains[PERIOD], gains[BOUND], int(gains[KIND_P]), gains[LAYER_P],
        gains[ADAPT], gains[GROWTH_MAX],
    )  # fmt: skip
    dlam = scratch(count)
    for i in range(count):
        dlam[i] = lam[regulated[i]] - lam_ref[i]
    force_integrate(force, dlam, gains[PERIOD], int(gains[KIND_F]), gains[LAYER_F])
    return status
