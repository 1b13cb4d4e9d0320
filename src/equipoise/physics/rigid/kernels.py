"""Kernels of equation (8): inertia and Delassus matrix factorised, multipliers, accelerations."""

from __future__ import annotations

import math

import numpy as np

from equipoise.compiled import compiled, entrance, scratch, scratch_matrix
from equipoise.compiled.workspace import Block, integers, matrix, part_of, vector
from equipoise.contacts.program import (
    DRIFT,
    RATE,
    RESIDUAL,
    contact_drifts,
    contact_rows,
    move_surfaces,
)
from equipoise.kinematics.kernels import VELOCITY, Q, move_joints, place_frames, place_joints
from equipoise.kinematics.manifold import integrate
from equipoise.physics.rigid.memory import (
    A_FREE,
    ACCELERATION,
    ACTIVE,
    AT,
    BILATERAL,
    COMPLIANCE,
    COULOMB,
    DAMPING,
    DELASSUS,
    FORCE,
    FREE,
    HALF,
    HALF_FREE,
    J_PHI,
    KEPT,
    L_FACTOR,
    LAM,
    MODE,
    OUTCOME,
    POSITION_GAIN,
    PROXIMAL,
    PUSHED,
    RHS,
    SETTINGS,
    SINGULAR,
    SLIP,
    SLIP_SPEED,
    SOLVED,
    STEP,
    STICK,
    TOTAL,
    TRAVEL,
    VELOCITY_GAIN,
    VIOLATION,
    VISCOSITY,
)

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
def look(floats: np.ndarray, whole: np.ndarray, tables: np.ndarray, t: float, part: int) -> None:
    """Place everything at the state (part 1 of the work), and write the contacts' rows (part 2)."""
    tree, state = part_of(floats, whole, tables, 0), part_of(floats, whole, tables, 1)
    contacts, work = part_of(floats, whole, tables, 2), part_of(floats, whole, tables, 3)
    if part & 1:
        place_joints(tree, state)
        place_frames(tree, state)
        move_joints(tree, state)
        move_surfaces(contacts, t)
    if part & 2:
        J = matrix(work, J_PHI)
        contact_rows(tree, state, contacts, J, integers(work, AT))
        contact_drifts(tree, state, contacts, J)
        let_faces_move(contacts, work)


@compiled
def let_faces_move(contacts: Block, work: Block) -> None:
    """Move the faces of pushed objects on, and note the largest violation of the other rows."""
    phi, travel, pushed = vector(contacts, RESIDUAL), vector(work, TRAVEL), integers(work, PUSHED)
    for i in range(pushed.shape[0]):
        if pushed[i] >= 0:
            phi[pushed[i]] += travel[i]
    settings, bilateral = vector(work, SETTINGS), integers(work, BILATERAL)
    for i in range(bilateral.shape[0]):
        if bilateral[i]:
            settings[VIOLATION] = max(settings[VIOLATION], abs(phi[i]))


@compiled
def reduce_to_contacts(
    contacts: Block, work: Block, v: np.ndarray, M: np.ndarray, bias: np.ndarray
) -> None:
    """Write what the contacts see of the robot, from M [nv, nv] (lower half), changed in place.

    L is the factor of M + h D; half [r, nv] = (L^-1 J^T)^T; half_free = L^-1 (force - bias - D v);
    delassus = J M^-1 J^T; slip_speed = J v - rate; a_free = J a without contact forces; and rhs,
    what the contact forces have to add to that, stabilised.
    """
    J, L, half = matrix(work, J_PHI), matrix(work, L_FACTOR), matrix(work, HALF)
    half_free, delassus, rhs = vector(work, HALF_FREE), matrix(work, DELASSUS), vector(work, RHS)
    slip_speed, a_free, settings = (
        vector(work, SLIP_SPEED), vector(work, A_FREE), vector(work, SETTINGS)
    )  # fmt: skip
    damping, force = vector(work, DAMPING), vector(work, FORCE)
    rate, phi, drift = vector(contacts, RATE), vector(contacts, RESIDUAL), vector(contacts, DRIFT)
    nv, r = v.shape[0], J.shape[0]
    free = scratch(nv)
    for i in range(nv):
        M[i, i] += settings[STEP] * damping[i]
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
        rhs[i] = (
            -drift[i]
            - settings[POSITION_GAIN] * phi[i]
            - settings[VELOCITY_GAIN] * speed
            - acceleration
        )
        for k in range(i + 1):
            total = 0.0
            for c in range(column(nv)):
                total += half[i, c] * half[k, c]
            delassus[i, k] = delassus[k, i] = total


@compiled
def multipliers(work: Block) -> bool:
    """Write lam [r] with (delassus + compliance) lam = rhs on the active rows, zero on the others.

    Redundant rows get a proximal term relative to the matrix, and one step of refinement. False if
    the matrix could not be factorised even so; then nothing is written.
    """
    delassus, rhs, lam = matrix(work, DELASSUS), vector(work, RHS), vector(work, LAM)
    active, kept, compliance = (
        integers(work, ACTIVE), integers(work, KEPT), vector(work, COMPLIANCE)
    )  # fmt: skip
    proximal, count = vector(work, SETTINGS)[PROXIMAL], 0
    for i in range(rhs.shape[0]):
        if active[i]:
            kept[count] = i
            count += 1
    matrix_, factor = scratch_matrix(count, count), scratch_matrix(count, count)
    wanted, x, more = scratch(count), scratch(count), scratch(count)
    trace = 0.0
    for i in range(count):
        wanted[i] = rhs[kept[i]]
        for k in range(count):
            matrix_[i, k] = delassus[kept[i], kept[k]]
        matrix_[i, i] += compliance[kept[i]]
        trace += matrix_[i, i]
    scale = proximal * trace / max(count, 1)
    for i in range(count):
        matrix_[i, i] += scale
    if not cholesky(matrix_, factor):
        return False
    forward(factor, wanted, x)
    backward(factor, x)
    for i in range(count):
        total = wanted[i] + scale * x[i]  # the residual of the matrix without the term
        for k in range(count):
            total -= matrix_[i, k] * x[k]
        more[i] = total
    for i in range(count):
        wanted[i] = more[i]
    forward(factor, wanted, more)
    backward(factor, more)
    lam[:] = 0.0
    for i in range(count):
        lam[kept[i]] = x[i] + more[i]
    return True


@compiled
def resolve(contacts: Block, work: Block) -> bool:
    """Write lam [r]: bilateral rows by (8), each pushed object in the mode that explains it."""
    active, compliance, pushed = (
        integers(work, ACTIVE), vector(work, COMPLIANCE), integers(work, PUSHED)
    )  # fmt: skip
    phi, mode = vector(contacts, RESIDUAL), integers(work, MODE)
    active[:] = 1
    compliance[:] = 0.0
    for i in range(pushed.shape[0]):
        row = pushed[i]
        if row >= 0:
            # touching begins where the gap closes and ends where the hand would have to pull
            touching = mode[i] != FREE or phi[row] <= 0.0
            mode[i] = STICK if touching else FREE
            active[row] = 1 if touching else 0
    if not multipliers(work):
        return False
    lam, rhs, h = vector(work, LAM), vector(work, RHS), vector(work, SETTINGS)[STEP]
    coulomb, viscosity = vector(work, COULOMB), vector(work, VISCOSITY)
    slip_speed, a_free = vector(work, SLIP_SPEED), vector(work, A_FREE)
    for i in range(pushed.shape[0]):
        row = pushed[i]
        if row < 0 or mode[i] != STICK:
            continue
        if lam[row] < 0.0:
            mode[i], active[row] = FREE, 0
        elif lam[row] > coulomb[i]:
            # v + h a = -(lam - coulomb) / viscosity, implicit in the viscous force
            mode[i], compliance[row] = SLIP, 1.0 / (viscosity[i] * h)
            rhs[row] = coulomb[i] / (viscosity[i] * h) - slip_speed[row] / h - a_free[row]
        else:
            continue
        if not multipliers(work):
            return False
    return True


@entrance
def solve(
    floats: np.ndarray, whole: np.ndarray, tables: np.ndarray, M: np.ndarray, bias: np.ndarray
) -> None:
    """Solve (8) for lam; the outcome tells whether the matrix could be factorised."""
    state = part_of(floats, whole, tables, 1)
    contacts, work = part_of(floats, whole, tables, 2), part_of(floats, whole, tables, 3)
    reduce_to_contacts(contacts, work, vector(state, VELOCITY), M, bias)
    integers(work, OUTCOME)[0] = SOLVED if resolve(contacts, work) else SINGULAR


@entrance
def accelerate(floats: np.ndarray, whole: np.ndarray, tables: np.ndarray, moving: bool) -> float:
    """Write `a = M^-1 (free + J^T lam)`; if `moving` take a step. Return a sum over the state."""
    tree, state = part_of(floats, whole, tables, 0), part_of(floats, whole, tables, 1)
    work = part_of(floats, whole, tables, 3)
    a, lam, total = vector(work, ACCELERATION), vector(work, LAM), vector(work, TOTAL)
    half, half_free = matrix(work, HALF), vector(work, HALF_FREE)
    for c in range(column(a.shape[0])):
        a[c] = half_free[c]
    for i in range(lam.shape[0]):
        for c in range(column(a.shape[0])):
            a[c] += half[i, c] * lam[i]
    backward(matrix(work, L_FACTOR), a)
    if not moving:
        return 0.0
    q, v, h, whole_sum = (
        vector(state, Q),
        vector(state, VELOCITY),
        vector(work, SETTINGS)[STEP],
        0.0,
    )
    for i in range(v.shape[0]):
        v[i] += h * a[i]
        whole_sum += v[i]
    integrate(tree, q, v, h)
    for i in range(q.shape[0]):
        whole_sum += q[i]
    for i in range(lam.shape[0]):
        total[i] += lam[i]
    return whole_sum
