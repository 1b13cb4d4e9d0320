"""Kinematics of a tree of joints: placements, world Jacobian, centre of mass, velocities, drifts.

`tree` is a block of `TREE`, `state` one of `STATE`. Row c of `columns` [nv, 6] is the twist that a
unit of velocity c gives to what it moves: the linear velocity of the point at the origin of the
world, then the angular velocity, in world axes. Velocities and accelerations of joints are of the
same form, which makes sums of them as simple as it gets. Joints that follow others have rows
behind these, for what the velocity of their leader gives to what they move.
"""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin

from equipoise.compiled import compiled, entrance, inlined, scratch
from equipoise.compiled.workspace import Arrays, Block, Shape, integers, matrix, part_of, vector
from equipoise.kinematics.tree import (
    ABOVE,
    AXIS,
    BELOW,
    CHAIN,
    CHAIN_COLUMN,
    CHAIN_COUNT,
    CHAIN_FIRST,
    CONTINUOUS,
    FIRST_COLUMN,
    FIRST_Q,
    FIRST_V,
    FOLLOWS,
    FRAME_JOINT,
    FRAME_PLACE,
    FREE,
    KIND,
    LAW,
    MASS,
    PARENT,
    PLACE,
    PLANAR,
    PRISMATIC,
    SUMMED,
    WIDTH,
    columns_in,
)
from equipoise.spatial.kernels import compose, crossed, quaternion_matrix, turned

STATE = Arrays(
    ("q", "v", "joints", "columns", "frames", "com", "com_rows", "moments", "velocities",
     "accelerations", "spins", "momentum_rate")
)  # fmt: skip
(Q, VELOCITY, JOINTS, COLUMNS, FRAMES, COM, COM_ROWS, MOMENTS, VELOCITIES, ACCELERATIONS, SPINS,
 MOMENTUM_RATE) = range(len(STATE.names))  # fmt: skip


def state_of(model: pin.Model, frames: int) -> list[tuple[str, Shape, bool]]:
    """Return the arrays of a state of a model with so many frames."""
    return state_shapes(model.nq, model.nv, model.njoints, frames, columns_in(model))


def state_shapes(
    nq: int, nv: int, joints: int, frames: int, columns: int
) -> list[tuple[str, Shape, bool]]:
    """Return the arrays of one state.

    `q` [nq], `v` [nv]; pose rows `joints` [joints, 12] and `frames` [frames, 12]; `columns`
    [columns, 6]; `com` [3] and `com_rows` [3, nv]; `moments` [joints, 3] are mass times centre of
    what a joint moves with; `velocities` and `accelerations` (at zero dv/dt) [joints, 6]. `spins`
    [joints, 9] and `momentum_rate` [6]: see `kinematics.momentum`.
    """
    return STATE.shapes(
        q=nq, v=nv, joints=(joints, 12), columns=(columns, 6), frames=(max(frames, 1), 12), com=3,
        com_rows=(3, nv), moments=(joints, 3), velocities=(joints, 6), accelerations=(joints, 6),
        spins=(joints, 9), momentum_rate=6,
    )  # fmt: skip


@compiled
def place_joints(tree: Block, state: Block) -> None:
    """Write placements and columns of all joints at q."""
    q, joints, columns = vector(state, Q), matrix(state, JOINTS), matrix(state, COLUMNS)
    place, axis, parent = matrix(tree, PLACE), matrix(tree, AXIS), integers(tree, PARENT)
    kind, first_q = integers(tree, KIND), integers(tree, FIRST_Q)
    follows, first = integers(tree, FOLLOWS), integers(tree, FIRST_COLUMN)
    world = joints[0]
    world[:] = 0.0
    world[0] = world[4] = world[8] = 1.0
    for j in range(1, joints.shape[0]):
        P, T, B, k = joints[parent[j]], joints[j], place[j], first_q[j]
        if kind[j] == FREE or kind[j] == PLANAR:
            place_base(q, k, kind[j], P, B, T)
            base_columns(T, kind[j], columns, first[j])
            continue
        angle, column = q[k], columns[first[j]]
        if follows[j]:
            angle = matrix(tree, LAW)[j, 0] * q[k] + matrix(tree, LAW)[j, 1]
        ax, ay, az = axis[j, 0], axis[j, 1], axis[j, 2]
        x, y, z = turned(P, B[9], B[10], B[11])
        T[9], T[10], T[11] = P[9] + x, P[10] + y, P[11] + z
        if kind[j] == PRISMATIC:
            for i in range(3):
                T[3 * i], T[3 * i + 1], T[3 * i + 2] = turned(
                    P, B[3 * i], B[3 * i + 1], B[3 * i + 2]
                )
            wx, wy, wz = turned(T, ax, ay, az)
            T[9], T[10], T[11] = T[9] + angle * wx, T[10] + angle * wy, T[11] + angle * wz
            column[0], column[1], column[2] = wx, wy, wz
            column[3] = column[4] = column[5] = 0.0
        else:
            if kind[j] == CONTINUOUS:
                c, s = q[k], q[k + 1]
            else:
                c, s = math.cos(angle), math.sin(angle)
            turn_joint(P, B, ax, ay, az, c, s, T)
            wx, wy, wz = turned(T, ax, ay, az)
            column[0], column[1], column[2] = crossed(T[9], T[10], T[11], wx, wy, wz)
            column[3], column[4], column[5] = wx, wy, wz
        if follows[j]:
            follow(tree, columns, j)


@compiled
def follow(tree: Block, columns: np.ndarray, j: int) -> None:
    """Turn the own column of joint j into that of its leader's speed; add what is above it."""
    own, ratio = columns[integers(tree, FIRST_COLUMN)[j]], matrix(tree, LAW)[j, 0]
    for i in range(6):
        own[i] *= ratio
    both = integers(tree, SUMMED)[j]
    if both >= 0:
        before = columns[integers(tree, ABOVE)[j]]
        for i in range(6):
            columns[both, i] = before[i] + own[i]


@inlined
def turn_joint(
    P: np.ndarray, B: np.ndarray, ax: float, ay: float, az: float, c: float, s: float, T: np.ndarray
) -> None:
    """Write the rotation P B R of a joint that turns about (ax, ay, az) by cosine c and sine s.

    Rodrigues: column i of R is c e_i + s a x e_i + (1 - c) a_i a.
    """
    d = 1.0 - c
    for i in range(3):
        if i == 0:
            x, y, z = c + d * ax * ax, s * az + d * ax * ay, -s * ay + d * ax * az
        elif i == 1:
            x, y, z = -s * az + d * ay * ax, c + d * ay * ay, s * ax + d * ay * az
        else:
            x, y, z = s * ay + d * az * ax, -s * ax + d * az * ay, c + d * az * az
        x, y, z = turned(B, x, y, z)
        T[3 * i], T[3 * i + 1], T[3 * i + 2] = turned(P, x, y, z)


@compiled
def place_base(
    q: np.ndarray, k: int, kind: int, P: np.ndarray, B: np.ndarray, T: np.ndarray
) -> None:
    """Write the placement of a free or planar base whose coordinates begin at q[k]."""
    if kind == FREE:
        own_pose(q, k, T)
    else:
        T[:] = 0.0
        T[0], T[1], T[3], T[4], T[8] = q[k + 2], q[k + 3], -q[k + 3], q[k + 2], 1.0
        T[9], T[10] = q[k], q[k + 1]
    for i in range(3):
        x, y, z = turned(B, T[3 * i], T[3 * i + 1], T[3 * i + 2])
        T[3 * i], T[3 * i + 1], T[3 * i + 2] = turned(P, x, y, z)
    x, y, z = turned(B, T[9], T[10], T[11])
    x, y, z = turned(P, B[9] + x, B[10] + y, B[11] + z)
    T[9], T[10], T[11] = P[9] + x, P[10] + y, P[11] + z


@compiled
def own_pose(q: np.ndarray, k: int, T: np.ndarray) -> None:
    """Write the pose row of position and quaternion xyzw at q[k : k + 7]."""
    quaternion_matrix(q[k + 3], q[k + 4], q[k + 5], q[k + 6], T)
    T[9], T[10], T[11] = q[k], q[k + 1], q[k + 2]


@compiled
def base_columns(T: np.ndarray, kind: int, columns: np.ndarray, first: int) -> None:
    """Write the columns of a base at T, whose velocity is a twist in its own axes."""
    c = first
    for i in range(3):  # linear; a planar base has x and y only
        if kind == FREE or i < 2:
            columns[c, 0], columns[c, 1], columns[c, 2] = T[3 * i], T[3 * i + 1], T[3 * i + 2]
            columns[c, 3] = columns[c, 4] = columns[c, 5] = 0.0
            c += 1
    for i in range(3):
        if kind == FREE or i == 2:
            ax, ay, az = T[3 * i], T[3 * i + 1], T[3 * i + 2]
            columns[c, 0], columns[c, 1], columns[c, 2] = crossed(T[9], T[10], T[11], ax, ay, az)
            columns[c, 3], columns[c, 4], columns[c, 5] = ax, ay, az
            c += 1


@compiled
def place_frames(tree: Block, state: Block) -> None:
    """Write the placements of the frames."""
    frames, joints, place = matrix(state, FRAMES), matrix(state, JOINTS), matrix(tree, FRAME_PLACE)
    joint = integers(tree, FRAME_JOINT)
    for f in range(frames.shape[0]):
        compose(joints[joint[f]], place[f], frames[f])


@compiled
def weigh(tree: Block, state: Block) -> None:
    """Write the centre of mass and its rows."""
    joints, columns, moments = matrix(state, JOINTS), matrix(state, COLUMNS), matrix(state, MOMENTS)
    mass, below, parent = matrix(tree, MASS), vector(tree, BELOW), integers(tree, PARENT)
    com, rows, first_v = vector(state, COM), matrix(state, COM_ROWS), integers(tree, FIRST_V)
    first, width, follows = (
        integers(tree, FIRST_COLUMN), integers(tree, WIDTH), integers(tree, FOLLOWS)
    )  # fmt: skip
    count = joints.shape[0]
    moments[0, 0] = moments[0, 1] = moments[0, 2] = 0.0
    for j in range(1, count):
        m = mass[j, 0]
        x, y, z = turned(joints[j], mass[j, 1], mass[j, 2], mass[j, 3])
        moments[j, 0] = m * (joints[j, 9] + x)
        moments[j, 1] = m * (joints[j, 10] + y)
        moments[j, 2] = m * (joints[j, 11] + z)
    for j in range(count - 1, 0, -1):
        for i in range(3):
            moments[parent[j], i] += moments[j, i]
    total = below[0]
    for i in range(3):
        com[i] = moments[0, i] / total
    for j in range(1, count):
        for k in range(width[j]):
            c, at = first[j] + k, first_v[j] + k
            x, y, z = crossed(
                columns[c, 3], columns[c, 4], columns[c, 5],
                moments[j, 0], moments[j, 1], moments[j, 2],
            )  # fmt: skip
            x, y, z = (
                (below[j] * columns[c, 0] + x) / total,
                (below[j] * columns[c, 1] + y) / total,
                (below[j] * columns[c, 2] + z) / total,
            )
            if follows[j]:  # its leader stands before it
                x, y, z = x + rows[0, at], y + rows[1, at], z + rows[2, at]
            rows[0, at], rows[1, at], rows[2, at] = x, y, z


@compiled
def move_joints(tree: Block, state: Block) -> None:
    """Write velocities of all joints at v, and their accelerations at zero dv/dt.

    A column moves with the joint before it: d column/dt = velocity x column, as spatial motions.
    """
    v, columns, parent = vector(state, VELOCITY), matrix(state, COLUMNS), integers(tree, PARENT)
    speed, drift = matrix(state, VELOCITIES), matrix(state, ACCELERATIONS)
    first_v, kind, count = integers(tree, FIRST_V), integers(tree, KIND), speed.shape[0]
    first, width = integers(tree, FIRST_COLUMN), integers(tree, WIDTH)
    for i in range(6):
        speed[0, i] = drift[0, i] = 0.0
    for j in range(1, count):
        p = parent[j]
        for i in range(6):
            own = 0.0
            for k in range(width[j]):
                own += columns[first[j] + k, i] * v[first_v[j] + k]
            speed[j, i] = own
            drift[j, i] = drift[p, i]
        if not (kind[j] == FREE or kind[j] == PLANAR):  # for a base the product is zero
            lx, ly, lz, ax, ay, az = (
                speed[j, 0], speed[j, 1], speed[j, 2], speed[j, 3], speed[j, 4], speed[j, 5]
            )  # fmt: skip
            vx, vy, vz, wx, wy, wz = (
                speed[p, 0], speed[p, 1], speed[p, 2], speed[p, 3], speed[p, 4], speed[p, 5]
            )  # fmt: skip
            x, y, z = crossed(wx, wy, wz, lx, ly, lz)
            u, r, s = crossed(vx, vy, vz, ax, ay, az)
            drift[j, 0] += x + u
            drift[j, 1] += y + r
            drift[j, 2] += z + s
            x, y, z = crossed(wx, wy, wz, ax, ay, az)
            drift[j, 3] += x
            drift[j, 4] += y
            drift[j, 5] += z
        for i in range(6):
            speed[j, i] += speed[p, i]


@inlined
def velocity_at(twist: np.ndarray, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return the velocity of the point of a body that is now at (x, y, z); `twist` [6] is its."""
    cx, cy, cz = crossed(twist[3], twist[4], twist[5], x, y, z)
    return twist[0] + cx, twist[1] + cy, twist[2] + cz


@inlined
def acceleration_at(
    twist: np.ndarray, drift: np.ndarray, x: float, y: float, z: float
) -> tuple[float, float, float]:
    """Return the acceleration of that point; `drift` [6] is the body's spatial acceleration."""
    vx, vy, vz = velocity_at(twist, x, y, z)
    ax, ay, az = velocity_at(drift, x, y, z)
    cx, cy, cz = crossed(twist[3], twist[4], twist[5], vx, vy, vz)
    return ax + cx, ay + cy, az + cz


@compiled
def frame_rows(
    tree: Block, state: Block, joint: int, T: np.ndarray, A: np.ndarray, at: int
) -> None:
    """Write to A[at : at + 6] velocity and angular velocity, in world axes, of a frame at T.

    Only the columns that move the joint are written: the others are zero for good.
    """
    columns, chain = matrix(state, COLUMNS), integers(tree, CHAIN)
    by, first = integers(tree, CHAIN_COLUMN), integers(tree, CHAIN_FIRST)[joint]
    px, py, pz = T[9], T[10], T[11]
    for k in range(first, first + integers(tree, CHAIN_COUNT)[joint]):
        c, column = chain[k], columns[by[k]]
        wx, wy, wz = column[3], column[4], column[5]
        A[at, c] = column[0] + wy * pz - wz * py
        A[at + 1, c] = column[1] + wz * px - wx * pz
        A[at + 2, c] = column[2] + wx * py - wy * px
        A[at + 3, c], A[at + 4, c], A[at + 5, c] = wx, wy, wz


@compiled
def clear_row(tree: Block, joint: int, A: np.ndarray, at: int) -> None:
    """Set to zero what moves a joint in row A[at]."""
    chain, first = integers(tree, CHAIN), integers(tree, CHAIN_FIRST)[joint]
    for k in range(first, first + integers(tree, CHAIN_COUNT)[joint]):
        A[at, chain[k]] = 0.0


@compiled
def add_point_row(
    tree: Block, state: Block, joint: int, p: np.ndarray, n: np.ndarray, sign: float,
    A: np.ndarray, at: int,
) -> None:  # fmt: skip
    """Add to A[at] the speed along `sign` n [3] of the point of a joint's body now at p [3]."""
    columns, chain = matrix(state, COLUMNS), integers(tree, CHAIN)
    by, first = integers(tree, CHAIN_COLUMN), integers(tree, CHAIN_FIRST)[joint]
    nx, ny, nz = sign * n[0], sign * n[1], sign * n[2]
    mx, my, mz = crossed(p[0], p[1], p[2], nx, ny, nz)
    for k in range(first, first + integers(tree, CHAIN_COUNT)[joint]):
        column = columns[by[k]]
        A[at, chain[k]] += (
            nx * column[0]
            + ny * column[1]
            + nz * column[2]
            + mx * column[3]
            + my * column[4]
            + mz * column[5]
        )


@compiled
def is_finite(x: np.ndarray) -> bool:
    """Tell whether no entry is NaN or infinite.

    Not by isfinite(): what the compiler may assume here makes that always true. A sum of huge
    numbers of both signs could hide nothing: it would be NaN or infinite itself.
    """
    total = 0.0
    for i in range(x.shape[0]):
        total += abs(x[i])
    return total < np.inf


# what `evaluate` computes besides the placements of the joints
WITH_FRAMES, WITH_COM, WITH_MOTION = 1, 2, 4


@entrance
def evaluate(
    floats: np.ndarray, whole: np.ndarray, tables: np.ndarray, number: int, q: np.ndarray,
    v: np.ndarray,
) -> bool:  # fmt: skip
    """Take a state (part `number` of the tables), if it is finite, and place its joints.

    The tree is part 0. Return whether it was finite.
    """
    tree, state = part_of(floats, whole, tables, 0), part_of(floats, whole, tables, number)
    if not (is_finite(q) and is_finite(v)):
        return False
    own_q, own_v = vector(state, Q), vector(state, VELOCITY)
    for i in range(q.shape[0]):
        own_q[i] = q[i]
    for i in range(v.shape[0]):
        own_v[i] = v[i]
    place_joints(tree, state)
    return True


@entrance
def evaluate_more(
    floats: np.ndarray, whole: np.ndarray, tables: np.ndarray, number: int, what: int
) -> None:
    """Compute frames, centre of mass or motion of the state whose joints are placed."""
    tree, state = part_of(floats, whole, tables, 0), part_of(floats, whole, tables, number)
    if what & WITH_FRAMES:
        place_frames(tree, state)
    if what & WITH_COM:
        weigh(tree, state)
    if what & WITH_MOTION:
        move_joints(tree, state)


@entrance
def frame_jacobian(
    floats: np.ndarray, whole: np.ndarray, tables: np.ndarray, number: int, joint: int,
    place: np.ndarray, J: np.ndarray,
) -> None:  # fmt: skip
    """Write the rows J [6, nv] of a frame at `place` [12] of a joint; J is zero at first."""
    tree, state = part_of(floats, whole, tables, 0), part_of(floats, whole, tables, number)
    T = scratch(12)
    compose(matrix(state, JOINTS)[joint], place, T)
    frame_rows(tree, state, joint, T, J, 0)


@entrance
def frame_motion(
    floats: np.ndarray, whole: np.ndarray, tables: np.ndarray, number: int, joint: int,
    place: np.ndarray, motion: np.ndarray,
) -> None:  # fmt: skip
    """Write the twist motion[0] [6] of a frame, and the drift motion[1] [6] of its rows."""
    state, T = part_of(floats, whole, tables, number), scratch(12)
    compose(matrix(state, JOINTS)[joint], place, T)
    speed, drift = matrix(state, VELOCITIES)[joint], matrix(state, ACCELERATIONS)[joint]
    motion[0, 0], motion[0, 1], motion[0, 2] = velocity_at(speed, T[9], T[10], T[11])
    motion[1, 0], motion[1, 1], motion[1, 2] = acceleration_at(speed, drift, T[9], T[10], T[11])
    for i in range(3, 6):
        motion[0, i], motion[1, i] = speed[i], drift[i]
