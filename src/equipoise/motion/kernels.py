"""Kernels of motion generation: where tasks are called, blended, solved, and their answer followed.

A new kind of task with a kernel is its file and a line in `task_rows`.

Tasks that fade: a weight on rows does nothing for strict priorities, since an equality scaled is
the same equality. What is blended is the answer. With weights w_1 >= ... >= w_m of what fades it
is `(1 - w_1) v(none) + (w_1 - w_2) v(first) + ... + w_m v(all)`, v(S) the optimum with the tasks of
S only. It depends continuously on the weights, and where they are 0 and 1 it is an optimum itself.
As the violation of a level is a convex function of v, each level is violated at most as much as the
same blend of the optima; levels above every fading task, where all optima agree, stay optimal.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from equipoise.collision.pairs import find_distances_there
from equipoise.compiled import compiled
from equipoise.compiled.workspace import Block, integers, matrix, part_of, vector
from equipoise.contacts.program import (
    ON,
    OWN_ROW,
    RATE,
    RESIDUAL,
    SIZE,
    contact_rows,
    move_surfaces,
)
from equipoise.hqp.solvers.active_set.memory import (
    A_ROWS,
    COUNTS,
    ENDS,
    FAILED,
    LOWER,
    SOLVED,
    UPPER,
    V,
)
from equipoise.hqp.solvers.active_set.memory import FIRST as ROW_BEGINS
from equipoise.hqp.solvers.active_set.memory import LAST as ROW_ENDS
from equipoise.hqp.solvers.active_set.solve import solve_there
from equipoise.kinematics.kernels import (
    VELOCITY,
    Q,
    move_joints,
    place_frames,
    place_joints,
    weigh,
)
from equipoise.kinematics.manifold import integrate
from equipoise.motion.easing import ease_rows
from equipoise.motion.memory import (
    AT,
    BLENDED,
    CLOCK,
    CLOCK_RATE,
    CONTACT_AT,
    CONTACT_HELD,
    CONTACT_RATE,
    EASED,
    FADE_OF,
    FADES,
    FIRST,
    FLAGS,
    FRAME,
    KIND,
    NEEDS_BEFORE,
    NEEDS_COM,
    NEEDS_MOTION,
    NUMBERS,
    PAIRS_PART,
    RATES,
    ROW_CONSTANT,
    ROW_WEIGHT,
    SEARCHES_FROM,
    SHARES,
    STATUS,
    TARGET,
    THRESHOLDS,
    USED,
    V_REF,
    WEIGHED,
    WEIGHTS,
    WINDOW,
)
from equipoise.tasks.avoidance import avoidance_rows
from equipoise.tasks.com_point import com_point_rows
from equipoise.tasks.com_polygon import com_rows
from equipoise.tasks.coupling import coupling_rows
from equipoise.tasks.damping import damping_rows
from equipoise.tasks.floor_support import support_rows
from equipoise.tasks.frame_axes import frame_axes_rows
from equipoise.tasks.frame_pose import frame_pose_rows
from equipoise.tasks.gaze import gaze_rows
from equipoise.tasks.joint_accelerations import acceleration_rows
from equipoise.tasks.joint_limits import limit_rows
from equipoise.tasks.manipulability import manipulability_rows
from equipoise.tasks.momentum import momentum_rows
from equipoise.tasks.posture import posture_rows
from equipoise.tasks.relative_frame import relative_frame_rows
from equipoise.tasks.view import (
    AVOIDANCE,
    COM_POINT,
    COM_POLYGON,
    COUPLING,
    DAMPING,
    FLOOR_SUPPORT,
    FRAME_AXES,
    FRAME_POSE,
    GAZE,
    JOINT_ACCELERATIONS,
    JOINT_LIMITS,
    KEEP_IN,
    KEEP_OUT,
    MANIPULABILITY,
    MOMENTUM,
    POSTURE,
    RELATIVE_FRAME,
    TaskView,
)
from equipoise.tasks.volumes import keep_in_rows, keep_out_rows
from equipoise.trajectories.fade import fade_weight
from equipoise.trajectories.targets import ROWS as TARGET_ROWS
from equipoise.trajectories.targets import evaluate_targets, live_numbers, slow_targets

WORK_LIMIT = 1000


class MotionBlocks(NamedTuple):
    """The parts of a motion: tree, reference state, targets, contacts, tasks, rows; all blocks."""

    tree: Block
    state: Block
    targets: Block
    contacts: Block
    tasks: Block
    rows: Block
    floats: np.ndarray
    whole: np.ndarray
    tables: np.ndarray


@compiled
def motion_begin(m: MotionBlocks, t: float) -> int:
    """Place everything at the reference at time t; return how many distances are left to Coal."""
    place_joints(m.tree, m.state)
    place_frames(m.tree, m.state)
    flags = integers(m.tasks, FLAGS)
    if flags[NEEDS_COM]:
        weigh(m.tree, m.state)
    if flags[NEEDS_BEFORE]:
        before, v_ref = vector(m.state, VELOCITY), vector(m.tasks, V_REF)
        for c in range(v_ref.shape[0]):
            before[c] = v_ref[c]
    if flags[NEEDS_MOTION]:
        move_joints(m.tree, m.state)
    evaluate_targets(m.targets, t)
    rate = vector(m.tasks, CLOCK)[CLOCK_RATE]
    if rate != 1.0:
        slow_targets(m.targets, rate)
    hold_contacts(m, t)
    kind, part, asked = integers(m.tasks, KIND), integers(m.tasks, PAIRS_PART), 0
    for k in range(kind.shape[0]):
        if kind[k] == AVOIDANCE:
            pairs = part_of(m.floats, m.whole, m.tables, part[k])
            asked += find_distances_there(m.state, pairs, 0)
    return asked


@compiled
def hold_contacts(m: MotionBlocks, t: float) -> None:
    """Write which contacts hold at time t; the rows of the others are free. Move surfaces."""
    window, on = matrix(m.tasks, WINDOW), integers(m.contacts, ON)
    size, at = integers(m.contacts, SIZE), integers(m.tasks, CONTACT_AT)
    lower, upper, held = (
        vector(m.rows, LOWER),
        vector(m.rows, UPPER),
        integers(m.tasks, CONTACT_HELD),
    )
    for k in range(on.shape[0]):
        on[k] = 1 if window[k, 0] <= t < window[k, 1] and held[k] else 0
        if not on[k]:
            for i in range(at[k], at[k] + size[k]):
                lower[i], upper[i] = -np.inf, np.inf
    move_surfaces(m.contacts, t)


@compiled
def write_rows(m: MotionBlocks) -> None:
    """Write the rows of all contacts and tasks."""
    A, lower, upper = matrix(m.rows, A_ROWS), vector(m.rows, LOWER), vector(m.rows, UPPER)
    at = integers(m.tasks, CONTACT_AT)
    contact_rows(m.tree, m.state, m.contacts, A, at)
    rate, residual = vector(m.contacts, RATE), vector(m.contacts, RESIDUAL)
    on, own = integers(m.contacts, ON), integers(m.contacts, OWN_ROW)
    size, back = integers(m.contacts, SIZE), vector(m.tasks, CONTACT_RATE)
    for k in range(on.shape[0]):
        if on[k]:
            for i in range(size[k]):
                bound = rate[own[k] + i] - back[k] * residual[own[k] + i]
                lower[at[k] + i] = upper[at[k] + i] = bound
    for k in range(integers(m.tasks, KIND).shape[0]):
        task_rows(m, k, A, lower, upper)
    if integers(m.tasks, FLAGS)[WEIGHED]:
        weigh_rows(m, A, lower, upper)
    if integers(m.tasks, FLAGS)[EASED]:
        ease_rows(m.tasks, m.rows)


@compiled
def weigh_rows(m: MotionBlocks, A: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> None:
    """Scale the rows that were just written by the weights of their tasks."""
    weight, constant = vector(m.tasks, ROW_WEIGHT), integers(m.tasks, ROW_CONSTANT)
    first, last = integers(m.rows, ROW_BEGINS), integers(m.rows, ROW_ENDS)
    for row in range(weight.shape[0]):
        w = weight[row]
        if w == 1.0 or (lower[row] == -np.inf and upper[row] == np.inf):
            continue  # what a free row says is old
        lower[row] *= w
        upper[row] *= w
        if not constant[row]:
            for c in range(first[row], last[row]):
                A[row, c] *= w


@compiled
def task_rows(m: MotionBlocks, k: int, A: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> None:
    """Write the rows of one task; those of a GIVEN one are written from Python."""
    kind, first = integers(m.tasks, KIND)[k], integers(m.tasks, FIRST)
    numbers = vector(m.tasks, NUMBERS)[first[k] : first[k + 1]]
    at, target = integers(m.tasks, AT)[k], integers(m.tasks, TARGET)[k]
    view = TaskView(
        m.tree, m.state, integers(m.tasks, FRAME)[k], matrix(m.targets, TARGET_ROWS)[target],
        live_numbers(m.targets, target), vector(m.tasks, RATES)[k], numbers, A, lower, upper, at,
    )  # fmt: skip
    if kind == FRAME_POSE:
        frame_pose_rows(view)
    elif kind == POSTURE:
        posture_rows(view)
    elif kind == JOINT_LIMITS:
        limit_rows(view)
    elif kind == COM_POLYGON:
        com_rows(view)
    elif kind == GAZE:
        gaze_rows(view)
    elif kind == JOINT_ACCELERATIONS:
        acceleration_rows(view)
    elif kind == FLOOR_SUPPORT:
        support_rows(view)
    elif kind == FRAME_AXES:
        frame_axes_rows(view)
    elif kind == COM_POINT:
        com_point_rows(view)
    elif kind == COUPLING:
        coupling_rows(view)
    elif kind == DAMPING:
        damping_rows(view)
    elif kind == KEEP_IN:
        keep_in_rows(view)
    elif kind == KEEP_OUT:
        keep_out_rows(view)
    elif kind == RELATIVE_FRAME:
        relative_frame_rows(view)
    elif kind == MOMENTUM:
        momentum_rows(view)
    elif kind == MANIPULABILITY:
        manipulability_rows(view)
    elif kind == AVOIDANCE:
        pairs = part_of(m.floats, m.whole, m.tables, integers(m.tasks, PAIRS_PART)[k])
        avoidance_rows(m.tree, m.state, pairs, numbers, A, lower, upper, at)


@compiled
def choose_parts(m: MotionBlocks, t: float) -> int:
    """Write the shares of the hierarchies of the blend at time t; return their number.

    Part i counts what fades with a weight of at least the i-th of those between 0 and 1, the last
    part what counts fully. The first has the most tasks.
    """
    weights, fades = vector(m.tasks, WEIGHTS), matrix(m.tasks, FADES)
    shares, thresholds = vector(m.tasks, SHARES), vector(m.tasks, THRESHOLDS)
    for f in range(weights.shape[0]):
        weights[f] = fade_weight(fades[f], t)
    count, below = 0, 0.0
    while True:
        least = 1.0
        for f in range(weights.shape[0]):
            if below < weights[f] < least:
                least = weights[f]
        shares[count], thresholds[count] = least - below, least
        count += 1
        if least == 1.0:
            return count
        below = least


@compiled
def count_rows(m: MotionBlocks, search: Block, least: float) -> None:
    """Let the rows count whose fade has at least a weight, and those without a fade."""
    counts, fade_of, weights = (
        integers(search, COUNTS),
        integers(m.tasks, FADE_OF),
        vector(m.tasks, WEIGHTS),
    )
    for row in range(counts.shape[0]):
        counts[row] = 1 if fade_of[row] < 0 or weights[fade_of[row]] >= least else 0


@compiled
def solve_motion(m: MotionBlocks, t: float, fading: bool) -> int:
    """Solve the hierarchies of the moment, leaving the answer as v_ref; return how it went."""
    flags, v_ref = integers(m.tasks, FLAGS), vector(m.tasks, V_REF)
    first = flags[SEARCHES_FROM]
    if not fading:
        search = part_of(m.floats, m.whole, m.tables, first)
        how = solve_there(m.rows, search, WORK_LIMIT)
        v = vector(search, V)
        for c in range(v_ref.shape[0]):
            v_ref[c] = v[c]
        flags[USED], flags[STATUS] = 1, how
        return how
    blended, shares = vector(m.tasks, BLENDED), vector(m.tasks, SHARES)
    count, how = choose_parts(m, t), SOLVED
    blended[:] = 0.0
    for part in range(count):
        search = part_of(m.floats, m.whole, m.tables, first + part)
        count_rows(m, search, vector(m.tasks, THRESHOLDS)[part])
        how = max(how, solve_there(m.rows, search, WORK_LIMIT))
        v = vector(search, V)
        for c in range(v.shape[0]):
            blended[c] += shares[part] * v[c]
    for c in range(v_ref.shape[0]):
        v_ref[c] = blended[c] if how != FAILED else 0.0
    flags[USED], flags[STATUS] = count, how
    return how


@compiled
def measure_levels(m: MotionBlocks, slack: np.ndarray) -> None:
    """Write by how much v_ref violates each level [levels], in the rows that count fully."""
    A, lower, upper = matrix(m.rows, A_ROWS), vector(m.rows, LOWER), vector(m.rows, UPPER)
    first, last, ends = (
        integers(m.rows, ROW_BEGINS),
        integers(m.rows, ROW_ENDS),
        integers(m.rows, ENDS),
    )
    fade_of, weights = integers(m.tasks, FADE_OF), vector(m.tasks, WEIGHTS)
    v, row = vector(m.tasks, V_REF), 0
    for level in range(slack.shape[0]):
        square = 0.0
        while row < ends[level]:
            fade = fade_of[row]
            bounded = lower[row] > -np.inf or upper[row] < np.inf
            if bounded and (fade < 0 or weights[fade] >= 1.0):
                value = 0.0
                for c in range(first[row], last[row]):
                    value += A[row, c] * v[c]
                short = max(lower[row] - value, value - upper[row], 0.0)
                square += short * short
            row += 1
        slack[level] = math.sqrt(square)


@compiled
def move_on(m: MotionBlocks, dt: float) -> None:
    """Follow v_ref for dt [s]."""
    integrate(m.tree, vector(m.state, Q), vector(m.tasks, V_REF), dt)
