"""Steps and differences on the manifold of configurations; velocities seen from another base."""

from __future__ import annotations

import math

import numpy as np

from equipoise.compiled import compiled, scratch, scratch_matrix
from equipoise.compiled.workspace import Block, integers
from equipoise.kinematics.kernels import own_pose
from equipoise.kinematics.tree import CONTINUOUS, FIRST_Q, FIRST_V, FOLLOWS, FREE, KIND, PLANAR
from equipoise.spatial.kernels import crossed, rotation_vector, turned, turned_back


@compiled
def integrate(tree: Block, q: np.ndarray, v: np.ndarray, dt: float) -> None:
    """Move q [nq] on by v [nv] for dt [s]: what Pinocchio's `integrate` does."""
    kind, first_q, first_v = integers(tree, KIND), integers(tree, FIRST_Q), integers(tree, FIRST_V)
    follows = integers(tree, FOLLOWS)
    for j in range(1, kind.shape[0]):
        k, c = first_q[j], first_v[j]
        if follows[j]:  # it has no coordinate of its own
            continue
        if kind[j] == FREE:
            integrate_free(q, k, v, c, dt)
        elif kind[j] == PLANAR:
            integrate_planar(q, k, v, c, dt)
        elif kind[j] == CONTINUOUS:
            turn(q, k, v[c] * dt)
        else:
            q[k] += v[c] * dt


@compiled
def turn(q: np.ndarray, k: int, angle: float) -> None:
    """Turn cosine and sine at q[k], q[k + 1] by an angle [rad], kept at unit length."""
    c, s = math.cos(angle), math.sin(angle)
    x, y = q[k] * c - q[k + 1] * s, q[k] * s + q[k + 1] * c
    length = math.sqrt(x * x + y * y)
    q[k], q[k + 1] = x / length, y / length


@compiled
def integrate_planar(q: np.ndarray, k: int, v: np.ndarray, c: int, dt: float) -> None:
    """Move x, y, cosine, sine on by a twist (x, y, turn) in the base's own axes."""
    angle, x, y = v[c + 2] * dt, v[c] * dt, v[c + 1] * dt
    if abs(angle) < 1e-4:
        along, across = 1.0 - angle * angle / 6.0, 0.5 * angle * (1.0 - angle * angle / 12.0)
    else:
        along, across = math.sin(angle) / angle, (1.0 - math.cos(angle)) / angle
    x, y = along * x - across * y, across * x + along * y
    q[k] += q[k + 2] * x - q[k + 3] * y
    q[k + 1] += q[k + 3] * x + q[k + 2] * y
    turn(q, k + 2, angle)


@compiled
def integrate_free(q: np.ndarray, k: int, v: np.ndarray, c: int, dt: float) -> None:
    """Move position and quaternion xyzw on by a twist in the base's own axes."""
    lx, ly, lz = v[c] * dt, v[c + 1] * dt, v[c + 2] * dt
    wx, wy, wz = v[c + 3] * dt, v[c + 4] * dt, v[c + 5] * dt
    square = wx * wx + wy * wy + wz * wz
    if square < 1e-6:  # the next terms are below 1e-15
        g = 0.5 - square / 24.0 + square * square / 720.0
        h = 1.0 / 6.0 - square / 120.0 + square * square / 5040.0
        sine = 0.5 - square / 48.0 + square * square / 3840.0
        cosine = 1.0 - square / 8.0 + square * square / 384.0
    else:
        angle = math.sqrt(square)
        g, h = (1.0 - math.cos(angle)) / square, (angle - math.sin(angle)) / (square * angle)
        sine, cosine = math.sin(0.5 * angle) / angle, math.cos(0.5 * angle)
    ax, ay, az = crossed(wx, wy, wz, lx, ly, lz)
    bx, by, bz = crossed(wx, wy, wz, ax, ay, az)
    T = scratch(12)
    own_pose(q, k, T)
    x, y, z = turned(T, lx + g * ax + h * bx, ly + g * ay + h * by, lz + g * az + h * bz)
    q[k], q[k + 1], q[k + 2] = q[k] + x, q[k + 1] + y, q[k + 2] + z
    x, y, z, w = q[k + 3], q[k + 4], q[k + 5], q[k + 6]
    dx, dy, dz = wx * sine, wy * sine, wz * sine
    q[k + 3] = w * dx + x * cosine + y * dz - z * dy
    q[k + 4] = w * dy - x * dz + y * cosine + z * dx
    q[k + 5] = w * dz + x * dy - y * dx + z * cosine
    q[k + 6] = w * cosine - x * dx - y * dy - z * dz
    length = 0.0
    for i in range(3, 7):
        length += q[k + i] * q[k + i]
    for i in range(3, 7):
        q[k + i] /= math.sqrt(length)


@compiled
def difference(tree: Block, q_from: np.ndarray, q: np.ndarray, out: np.ndarray) -> None:
    """Write the velocity [nv] that carries q_from to q in a unit of time: Pinocchio's `difference`.

    `out` may not be one of the others.
    """
    kind, first_q, first_v = integers(tree, KIND), integers(tree, FIRST_Q), integers(tree, FIRST_V)
    follows = integers(tree, FOLLOWS)
    for j in range(1, kind.shape[0]):
        k, c = first_q[j], first_v[j]
        if follows[j]:  # it has no coordinate of its own
            continue
        if kind[j] == FREE:
            difference_free(q_from, q, k, out, c)
        elif kind[j] == PLANAR:
            difference_planar(q_from, q, k, out, c)
        elif kind[j] == CONTINUOUS:
            cosine = q_from[k] * q[k] + q_from[k + 1] * q[k + 1]
            out[c] = math.atan2(q_from[k] * q[k + 1] - q_from[k + 1] * q[k], cosine)
        else:
            out[c] = q[k] - q_from[k]


@compiled
def difference_planar(q_from: np.ndarray, q: np.ndarray, k: int, out: np.ndarray, c: int) -> None:
    """Write the difference of planar bases, as a twist in the axes of the first."""
    cosine, sine = q_from[k + 2], q_from[k + 3]
    dx, dy = q[k] - q_from[k], q[k + 1] - q_from[k + 1]
    x, y = cosine * dx + sine * dy, -sine * dx + cosine * dy
    angle = math.atan2(cosine * q[k + 3] - sine * q[k + 2], cosine * q[k + 2] + sine * q[k + 3])
    half = 0.5 * angle
    along = 1.0 - half * half / 3.0 if abs(half) < 1e-4 else half / math.tan(half)
    out[c], out[c + 1], out[c + 2] = along * x + half * y, -half * x + along * y, angle


@compiled
def difference_free(q_from: np.ndarray, q: np.ndarray, k: int, out: np.ndarray, c: int) -> None:
    """Write the difference of free bases, as a twist in the axes of the first."""
    A, B, r = scratch(12), scratch(12), scratch_matrix(3, 3)
    own_pose(q_from, k, A)
    own_pose(q, k, B)
    for i in range(3):
        for m in range(3):
            r[i, m] = (
                A[3 * i] * B[3 * m] + A[3 * i + 1] * B[3 * m + 1] + A[3 * i + 2] * B[3 * m + 2]
            )
    px, py, pz = turned_back(A, B[9] - A[9], B[10] - A[10], B[11] - A[11])
    wx, wy, wz = rotation_vector(r)
    square = wx * wx + wy * wy + wz * wz
    if square < 1e-4:
        bent = 1.0 / 12.0 + square / 720.0 + square * square / 30240.0
    else:
        angle = math.sqrt(square)
        bent = 1.0 / square - (1.0 + math.cos(angle)) / (2.0 * angle * math.sin(angle))
    ax, ay, az = crossed(wx, wy, wz, px, py, pz)
    bx, by, bz = crossed(wx, wy, wz, ax, ay, az)
    out[c], out[c + 1], out[c + 2] = (
        px - 0.5 * ax + bent * bx,
        py - 0.5 * ay + bent * by,
        pz - 0.5 * az + bent * bz,
    )
    out[c + 3], out[c + 4], out[c + 5] = wx, wy, wz


@compiled
def velocity_difference(
    tree: Block, q: np.ndarray, v: np.ndarray, q_ref: np.ndarray, v_ref: np.ndarray, dv: np.ndarray
) -> None:
    """Write `v - Ad v_ref` [nv]: the wanted twist of a base is seen from the actual base first."""
    kind, first_q = integers(tree, KIND), integers(tree, FIRST_Q)
    for i in range(v.shape[0]):
        dv[i] = v[i] - v_ref[i]
    if kind.shape[0] < 2:
        return
    k = first_q[1]
    if kind[1] == FREE:
        base, ref = scratch(12), scratch(12)
        own_pose(q, k, base)
        own_pose(q_ref, k, ref)
        vx, vy, vz = turned(ref, v_ref[0], v_ref[1], v_ref[2])
        wx, wy, wz = turned(ref, v_ref[3], v_ref[4], v_ref[5])
        px, py, pz = ref[9] - base[9], ref[10] - base[10], ref[11] - base[11]
        cx, cy, cz = crossed(px, py, pz, wx, wy, wz)
        vx, vy, vz = turned_back(base, vx + cx, vy + cy, vz + cz)
        wx, wy, wz = turned_back(base, wx, wy, wz)
        dv[0], dv[1], dv[2] = v[0] - vx, v[1] - vy, v[2] - vz
        dv[3], dv[4], dv[5] = v[3] - wx, v[4] - wy, v[5] - wz
    elif kind[1] == PLANAR:
        x, y = q_ref[k] - q[k], q_ref[k + 1] - q[k + 1]
        vx = q_ref[k + 2] * v_ref[0] - q_ref[k + 3] * v_ref[1] + y * v_ref[2]
        vy = q_ref[k + 3] * v_ref[0] + q_ref[k + 2] * v_ref[1] - x * v_ref[2]
        dv[0] = v[0] - q[k + 2] * vx - q[k + 3] * vy
        dv[1] = v[1] + q[k + 3] * vx - q[k + 2] * vy
