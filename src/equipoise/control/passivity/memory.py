"""The memory of the law: what it keeps from tick to tick, and what it works in."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from equipoise.compiled import inlined
from equipoise.compiled.workspace import Arrays, Block, Shape, matrix_at, vector_at

LAW = Arrays(
    ("J", "L", "reflectors", "K_d", "unroot", "tau_max", "gains", "posture", "force", "lam",
     "lam_ref", "q_ref", "v_ref", "dq", "dv", "s", "u", "u_before", "handover", "reaction", "lam_0",
     "costs", "terms", "centres", "loads", "found", "carried", "tau", "tau_slow", "s_slow",
     "settles", "clock", "pivots", "at", "regulated", "supporting", "normal_rows", "ends", "flags"),
    frozenset({"pivots", "at", "regulated", "supporting", "normal_rows", "ends", "flags"}),
)  # fmt: skip
(J_PHI, L_FACTOR, REFLECTORS, K_D, UNROOT, TAU_MAX, GAINS, POSTURE, FORCE, LAM, LAM_REF, Q_REF,
 V_REF, DQ, DV, S, U, U_BEFORE, HANDOVER, REACTION, LAM_0, COSTS, TERMS, CENTRES, LOADS, FOUND,
 CARRIED, TAU, TAU_SLOW, S_SLOW, SETTLES, CLOCK, PIVOTS, AT, REGULATED, SUPPORTING, NORMAL_ROWS,
 ENDS, FLAGS) = range(len(LAW.names))  # fmt: skip

# entries of `gains`
(ALPHA, BETA_P, K_IP, BOUND, KIND_P, LAYER_P, BETA_F, K_IF, KIND_F, LAYER_F, BETA, MU, ETA, FADE,
 DAMP_VIOLATION, PERIOD, OBSERVER, IN_METRIC, RELAX, ROOT, ADAPT,
 GROWTH_MAX) = range(22)  # fmt: skip
GAIN_COUNT = 22
# entries of `clock`: when posture and force manifold, the last hand-over and the last set of
# supports began [s]
T_POSTURE, T_FORCE, T_HANDOVER, T_SUPPORTS = range(4)
# entries of `flags`: whether the manifolds run, contacts were switched just now, a difference is
# being handed over, the reaction is being observed; numbers of rows and contacts; the rank; whether
# the supporting reactions are bounded; whether the targets wait for the robot; whether supports
# changed just now; how the load is split
(STARTED, SWITCHING, HANDING_OVER, OBSERVING, ROW_COUNT, REGULATED_COUNT, SUPPORTING_COUNT,
 SUPPORT_COUNT, RANK, BOUNDED, WAITING, MAPPING, SPLIT) = range(13)  # fmt: skip
FLAG_COUNT = 13
LANDED, LIFTED = 1, 2  # which change of supports is mapped: none went, some did
BY_MEASURE, BY_ZMP = range(2)  # how the load is split
# what a copy of the memory consists of; J and lam are those of a contact that is lost next
KEPT = ("J", "lam", "posture", "force", "u_before", "handover", "reaction", "lam_0", "found",
        "carried", "tau", "tau_slow", "s_slow", "settles", "clock", "flags")  # fmt: skip


class LawSizes(NamedTuple):
    """How large the law's arrays are at most: contacts, their rows, the regulated, supporting."""

    nq: int
    nv: int
    na: int
    contacts: int
    rows: int
    regulated: int
    supporting: int
    supports: int


def law_shapes(sizes: LawSizes) -> list[tuple[str, Shape, bool]]:
    """Return the arrays of the law.

    `found` is the supporting reaction that was measured when the supports last changed, `carried`
    the generalised force of contacts that were lost then. `tau_slow` and `s_slow` are torque and
    s_p without noise, `settles` what of their noise was in the torque of the last switch.
    `centres` are of the soles, in their axes; `loads` what each support carries, as a multiple of
    the mean.
    """
    nq, nv, na = sizes.nq, sizes.nv, sizes.na
    r, k = max(sizes.rows, 1), max(sizes.regulated, 1)
    f, n = max(sizes.supporting, 1), max(sizes.supports, 1)
    return LAW.shapes(
        J=(r, nv), L=(r, nv), reflectors=(r, nv), K_d=(nv, nv), unroot=(nv, nv), tau_max=na,
        gains=GAIN_COUNT, posture=(6, nv), force=(6, k), lam=r, lam_ref=k, q_ref=nq, v_ref=nv,
        dq=nv, dv=nv, s=nv, u=nv, u_before=nv, handover=nv, reaction=f, lam_0=f, costs=f,
        terms=(2, f), centres=(n, 2), loads=n, found=f, carried=nv, tau=na, tau_slow=na,
        s_slow=nv, settles=nv, clock=4, pivots=r, at=max(sizes.contacts, 1),
        regulated=k, supporting=f, normal_rows=n,
        ends=n, flags=FLAG_COUNT,
    )  # fmt: skip


@inlined
def leading_rows(law: Block, name: int, rows: int) -> np.ndarray:
    """Return the first rows of a matrix of the law."""
    return matrix_at(law.floats, law.table[name, 0], rows, law.table[name, 2])


@inlined
def leading(law: Block, name: int, size: int) -> np.ndarray:
    """Return the first entries of a vector of floats."""
    return vector_at(law.floats, law.table[name, 0], size)


@inlined
def leading_whole(law: Block, name: int, size: int) -> np.ndarray:
    """Return the first entries of a vector of integers."""
    return vector_at(law.integers, law.table[name, 0], size)


@inlined
def packed(law: Block, name: int, rows: int, columns: int) -> np.ndarray:
    """Return the first numbers of an array as a matrix [rows, columns]."""
    return matrix_at(law.floats, law.table[name, 0], rows, columns)
