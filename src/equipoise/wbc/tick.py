"""The fused tick: motion, wanted forces, law and base wrench in one call over one workspace.

The parts stand in this order: the tree (0), the motion's (from 1), the scalars, the law's, where
they meet; after them the distances and searches of the motion.
"""

from __future__ import annotations

import numpy as np

from equipoise.compiled import compiled, entrance, scratch
from equipoise.compiled.workspace import Block, integers, part_of, vector
from equipoise.control.passivity.kernels import HELD, RUN, SATURATED, law_begin, law_tick
from equipoise.control.passivity.memory import (
    DQ,
    LAM,
    LAM_REF,
    Q_REF,
    REACTION,
    REGULATED_COUNT,
    SUPPORTING_COUNT,
    TAU,
    V_REF,
    WAITING,
    S,
    U,
)
from equipoise.control.passivity.memory import FLAGS as LAW_FLAGS
from equipoise.kinematics.kernels import VELOCITY, Q, is_finite
from equipoise.kinematics.manifold import difference
from equipoise.kinematics.tree import base_size
from equipoise.motion.governor import follow_clock
from equipoise.motion.kernels import MotionBlocks, motion_begin, move_on, solve_motion, write_rows
from equipoise.motion.memory import CLOCK, CLOCK_TIME, GOVERNED
from equipoise.motion.memory import V_REF as MOTION_V_REF
from equipoise.trajectories.scalars import evaluate_scalars, wanted_now
from equipoise.wbc.leaning import lean
from equipoise.wbc.memory import (
    FADING,
    FASTEST,
    FLAGS,
    LEANING,
    NUMBERS,
    PERIOD,
    POSTURE_ERROR,
    TILT,
    WANTED_OF,
)

# numbers of the parts
REFERENCE, TARGETS, CONTACTS, TASKS, ROWS = range(1, 6)
SCALARS, MEASURED, LAW_CONTACTS, LAW, BOUNDS, BOUND_ROWS, BOUND_SEARCH, MEETING = range(6, 14)

# parts of a tick; between them stands what Python has to see or to find out
BEGIN_MOTION, WRITE_ROWS, SOLVE_MOTION, WANT, BEGIN_LAW, RUN_LAW, MOVE = 1, 2, 4, 8, 16, 32, 64
WHOLE = 127
# how a tick went, beside RUN, SATURATED and HELD of the law: the supervisor has to look, or
# distances are left to Coal
WATCH, ASKED = 10, 11
SUPERVISED = HELD, WATCH  # after these the supervisor runs the law


@entrance
def tick(
    floats: np.ndarray, whole: np.ndarray, tables: np.ndarray, t: float, q: np.ndarray,
    v: np.ndarray, lam: np.ndarray, part: int, result: np.ndarray,
) -> int:  # fmt: skip
    """Run a tick, or parts of it, for measured q [nq], v [nv], lam [r]; return how it went.

    What is wanted is that of the governor's time, if there is one, and of `t` otherwise. `result`
    gets q_ref, v_ref, tau, u, s and the reaction F, one after the other. The reference
    moves on only after the law has run.
    """
    m = MotionBlocks(
        part_of(floats, whole, tables, 0), part_of(floats, whole, tables, REFERENCE),
        part_of(floats, whole, tables, TARGETS), part_of(floats, whole, tables, CONTACTS),
        part_of(floats, whole, tables, TASKS), part_of(floats, whole, tables, ROWS), floats, whole,
        tables,
    )  # fmt: skip
    law, meeting = part_of(floats, whole, tables, LAW), part_of(floats, whole, tables, MEETING)
    clock = vector(m.tasks, CLOCK)
    governed, wanted_at = clock[GOVERNED] != 0.0, t
    if governed:
        wanted_at = clock[CLOCK_TIME]
    if part & BEGIN_MOTION and motion_begin(m, wanted_at) > 0:
        return ASKED
    if part & WRITE_ROWS:
        write_rows(m)
    if part & SOLVE_MOTION:
        solve_motion(m, wanted_at, integers(meeting, FLAGS)[FADING] != 0)
    if part & WANT:
        want(
            m, part_of(floats, whole, tables, SCALARS),
            part_of(floats, whole, tables, LAW_CONTACTS), law, meeting, wanted_at,
        )  # fmt: skip
    how = RUN
    if part & (BEGIN_LAW | RUN_LAW):
        how = run_law(floats, whole, tables, t, q, v, lam, part)
        if how in SUPERVISED:
            return how
    if part & RUN_LAW:
        write_result(m, law, result)
    if part & MOVE:
        if governed:
            govern(m, law, vector(meeting, NUMBERS)[PERIOD], how == SATURATED)
        move_on(m, vector(meeting, NUMBERS)[PERIOD])
    return how


@compiled
def govern(m: MotionBlocks, law: Block, dt: float, clamped: bool) -> None:
    """Let the time of the targets go on; the law notes whether they wait for the robot."""
    dq, behind = vector(law, DQ), 0.0
    for i in range(dq.shape[0]):
        behind = max(behind, abs(dq[i]))
    waiting = follow_clock(m, dt, behind, clamped)
    integers(law, LAW_FLAGS)[WAITING] = 1 if waiting else 0


@compiled
def want(
    m: MotionBlocks, scalars: Block, contacts: Block, law: Block, meeting: Block, t: float
) -> None:
    """Give the law its reference: q_ref, v_ref and the wanted multipliers of what holds."""
    copy(vector(m.state, Q), vector(law, Q_REF))
    copy(vector(m.tasks, MOTION_V_REF), vector(law, V_REF))
    evaluate_scalars(scalars, t)
    wanted, lam_ref = integers(meeting, WANTED_OF), vector(law, LAM_REF)
    for i in range(integers(law, LAW_FLAGS)[REGULATED_COUNT]):
        lam_ref[i] = wanted_now(scalars, wanted[i])
    if integers(meeting, FLAGS)[LEANING]:
        lean(m, contacts, law, meeting, vector(meeting, NUMBERS)[PERIOD])


@compiled
def run_law(
    floats: np.ndarray, whole: np.ndarray, tables: np.ndarray, t: float, q: np.ndarray,
    v: np.ndarray, lam: np.ndarray, part: int,
) -> int:  # fmt: skip
    """Run the law on a measurement, unless the supervisor has to look at it first."""
    tree, state = part_of(floats, whole, tables, 0), part_of(floats, whole, tables, MEASURED)
    contacts = part_of(floats, whole, tables, LAW_CONTACTS)
    law, meeting = part_of(floats, whole, tables, LAW), part_of(floats, whole, tables, MEETING)
    if part & BEGIN_LAW:
        if not (is_finite(q) and is_finite(v) and is_finite(lam)):
            return WATCH
        copy(q, vector(state, Q))
        copy(v, vector(state, VELOCITY))
        copy(lam, vector(law, LAM))
        law_begin(tree, state, contacts, t)
    if not part & RUN_LAW:
        return RUN
    if not is_near(tree, state, law, meeting):
        return WATCH
    return law_tick(
        tree, state, contacts, law, part_of(floats, whole, tables, BOUNDS),
        part_of(floats, whole, tables, BOUND_ROWS), part_of(floats, whole, tables, BOUND_SEARCH), t,
    )  # fmt: skip


@compiled
def is_near(tree: Block, state: Block, law: Block, meeting: Block) -> bool:
    """Tell whether the robot is as near to its reference as the law needs it, and not too fast."""
    limits, q_ref, v = vector(meeting, NUMBERS), vector(law, Q_REF), vector(state, VELOCITY)
    if not is_finite(q_ref):
        return False
    nv, base, fastest = v.shape[0], base_size(tree), vector(meeting, FASTEST)
    for k in range(nv - base):
        if not abs(v[base + k]) <= fastest[k]:
            return False
    apart = scratch(nv)
    difference(tree, q_ref, vector(state, Q), apart)
    for i in range(nv):
        if not abs(apart[i]) < limits[POSTURE_ERROR]:
            return False
    if base == 6:
        square = apart[3] * apart[3] + apart[4] * apart[4] + apart[5] * apart[5]
        return square <= limits[TILT] * limits[TILT]
    return True


@compiled
def write_result(m: MotionBlocks, law: Block, result: np.ndarray) -> None:
    """Write what a tick gives, one array after the other."""
    at = append(vector(m.state, Q), result, 0)
    at = append(vector(m.tasks, MOTION_V_REF), result, at)
    at = append(vector(law, TAU), result, at)
    at = append(vector(law, U), result, at)
    at = append(vector(law, S), result, at)
    F = vector(law, REACTION)
    for i in range(integers(law, LAW_FLAGS)[SUPPORTING_COUNT]):
        result[at + i] = F[i]


@compiled
def append(x: np.ndarray, out: np.ndarray, at: int) -> int:
    """Copy x to out[at:]; return where it ends."""
    for i in range(x.shape[0]):
        out[at + i] = x[i]
    return at + x.shape[0]


@compiled
def copy(x: np.ndarray, out: np.ndarray) -> None:
    """Copy x to the beginning of `out`."""
    for i in range(x.shape[0]):
        out[i] = x[i]
