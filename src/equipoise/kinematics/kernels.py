"""Rows of frames and points from Pinocchio's world Jacobian, and the drifts of frames.

`columns` [nv, 6] is the world Jacobian transposed: for each velocity the linear velocity that it
gives the point of the body at the origin of the world, and its angular velocity. `frames` [k, 12]
and `joints` [n, 12] hold pose rows (see `spatial_kernels`). `carried` [nv] tells which velocities
move the body at hand.
"""

from __future__ import annotations

import numpy as np

from equipoise.compiled.compilation import compiled, entrance, inlined
from equipoise.spatial.kernels import crossed, turned


@entrance
def frame_rows(
    columns: np.ndarray, carried: np.ndarray, T: np.ndarray, A: np.ndarray, at: int
) -> None:
    """Write to A[at : at + 6] velocity and angular velocity, in world axes, of a frame at T."""
    px, py, pz = T[9], T[10], T[11]
    for c in range(columns.shape[0]):
        if carried[c]:
            wx, wy, wz = columns[c, 3], columns[c, 4], columns[c, 5]
            A[at, c] = columns[c, 0] + wy * pz - wz * py
            A[at + 1, c] = columns[c, 1] + wz * px - wx * pz
            A[at + 2, c] = columns[c, 2] + wx * py - wy * px
            A[at + 3, c], A[at + 4, c], A[at + 5, c] = wx, wy, wz
        else:
            for i in range(6):
                A[at + i, c] = 0.0


@compiled
def add_point_row(
    columns: np.ndarray,
    carried: np.ndarray,
    p: np.ndarray,
    n: np.ndarray,
    sign: float,
    A: np.ndarray,
    at: int,
) -> None:
    """Add to A[at] the speed along `sign` n [3] of a body point that is now at p [3]."""
    nx, ny, nz = sign * n[0], sign * n[1], sign * n[2]
    mx, my, mz = crossed(p[0], p[1], p[2], nx, ny, nz)
    for c in range(columns.shape[0]):
        if carried[c]:
            A[at, c] += (
                nx * columns[c, 0]
                + ny * columns[c, 1]
                + nz * columns[c, 2]
                + mx * columns[c, 3]
                + my * columns[c, 4]
                + mz * columns[c, 5]
            )


@compiled
def joint_rows(A: np.ndarray, at: int, count: int) -> None:
    """Write to A[at : at + count] the velocities of the joints, which follow the base's six."""
    for i in range(at, at + count):
        for c in range(A.shape[1]):
            A[i, c] = 0.0
        A[i, 6 + i - at] = 1.0


@inlined
def twist_of(
    joint: np.ndarray, velocity: np.ndarray, T: np.ndarray
) -> tuple[float, float, float, float, float, float]:
    """Return velocity and angular velocity, in world axes, of a frame at T on a joint's body.

    `joint` [12] is the pose row of the joint, `velocity` [6] its twist in its own axes.
    """
    wx, wy, wz = turned(joint, velocity[3], velocity[4], velocity[5])
    vx, vy, vz = turned(joint, velocity[0], velocity[1], velocity[2])
    rx, ry, rz = T[9] - joint[9], T[10] - joint[10], T[11] - joint[11]
    cx, cy, cz = crossed(wx, wy, wz, rx, ry, rz)
    return vx + cx, vy + cy, vz + cz, wx, wy, wz


@entrance
def frame_motion(
    joint: np.ndarray,
    velocity: np.ndarray,
    acceleration: np.ndarray,
    T: np.ndarray,
    out: np.ndarray,
) -> None:
    """Write to out[0] [6] the twist of a frame at T, to out[1] its acceleration, in world axes.

    `acceleration` [6] is the spatial acceleration of the joint in its own axes, at zero dv/dt; that
    of the frame is the one of its origin, which is the drift of its rows.
    """
    vx, vy, vz, wx, wy, wz = twist_of(joint, velocity, T)
    ax, ay, az = turned(joint, acceleration[0], acceleration[1], acceleration[2])
    bx, by, bz = turned(joint, acceleration[3], acceleration[4], acceleration[5])
    rx, ry, rz = T[9] - joint[9], T[10] - joint[10], T[11] - joint[11]
    ex, ey, ez = crossed(bx, by, bz, rx, ry, rz)
    cx, cy, cz = crossed(wx, wy, wz, vx, vy, vz)
    out[0, 0], out[0, 1], out[0, 2] = vx, vy, vz
    out[0, 3], out[0, 4], out[0, 5] = wx, wy, wz
    out[1, 0], out[1, 1], out[1, 2] = ax + ex + cx, ay + ey + cy, az + ez + cz
    out[1, 3], out[1, 4], out[1, 5] = bx, by, bz


@entrance
def is_finite(q: np.ndarray, v: np.ndarray) -> bool:
    """Tell whether no entry is NaN or infinite.

    Not by isfinite(): what the compiler may assume here makes that always true.
    """
    total = 0.0
    for i in range(q.shape[0]):
        total += q[i]
    for i in range(v.shape[0]):
        total += v[i]
    return abs(total) < np.inf


@entrance
def take_state(q: np.ndarray, v: np.ndarray, kept: np.ndarray) -> bool:
    """Copy q [nq] to `kept` if q and v [nv] are finite; tell whether they are."""
    if not is_finite(q, v):
        return False
    for i in range(q.shape[0]):
        kept[i] = q[i]
    return True
