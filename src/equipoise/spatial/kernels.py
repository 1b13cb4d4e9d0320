"""SE(3) as kernels need it: poses are rows of twelve numbers, as Pinocchio keeps them in memory.

A pose row holds the rotation column by column, then the translation: R[i, k] = row[3 k + i].
"""

from __future__ import annotations

import math

import numpy as np

from equipoise.compiled import compiled, inlined, scratch, scratch_matrix


@inlined
def turned(T: np.ndarray, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return R (x, y, z) of a pose row T [12]."""
    return (
        T[0] * x + T[3] * y + T[6] * z,
        T[1] * x + T[4] * y + T[7] * z,
        T[2] * x + T[5] * y + T[8] * z,
    )


@inlined
def turned_back(T: np.ndarray, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return R^T (x, y, z) of a pose row T [12]."""
    return (
        T[0] * x + T[1] * y + T[2] * z,
        T[3] * x + T[4] * y + T[5] * z,
        T[6] * x + T[7] * y + T[8] * z,
    )


@inlined
def crossed(
    ax: float, ay: float, az: float, bx: float, by: float, bz: float
) -> tuple[float, float, float]:
    """Return a x b."""
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@compiled
def rotation_difference(T_ref: np.ndarray, T: np.ndarray) -> tuple[float, float, float]:
    """Return the rotation vector [rad] of R_ref R^T, in world axes, by way of a quaternion."""
    r = scratch_matrix(3, 3)
    for i in range(3):
        for k in range(3):
            r[i, k] = T_ref[i] * T[k] + T_ref[3 + i] * T[3 + k] + T_ref[6 + i] * T[6 + k]
    return rotation_vector(r)


@compiled
def rotation_vector(r: np.ndarray) -> tuple[float, float, float]:
    """Return the rotation vector [rad], of length at most pi, of a rotation matrix [3, 3]."""
    trace = r[0, 0] + r[1, 1] + r[2, 2]
    if trace > 0.0:
        w = 0.5 * math.sqrt(1.0 + trace)
        scale = 0.25 / w
        x, y, z = r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]
        x, y, z = x * scale, y * scale, z * scale
    else:
        i = 0
        if r[1, 1] > r[0, 0]:
            i = 1
        if r[2, 2] > r[i, i]:
            i = 2
        k, m = (i + 1) % 3, (i + 2) % 3
        large = 0.5 * math.sqrt(1.0 + r[i, i] - r[k, k] - r[m, m])
        scale = 0.25 / large
        w = (r[m, k] - r[k, m]) * scale
        parts = scratch(3)
        parts[i] = large
        parts[k] = (r[k, i] + r[i, k]) * scale
        parts[m] = (r[m, i] + r[i, m]) * scale
        x, y, z = parts[0], parts[1], parts[2]
    if w < 0.0:
        w, x, y, z = -w, -x, -y, -z
    sine = math.sqrt(x * x + y * y + z * z)
    stretch = 2.0 * math.atan2(sine, w) / sine if sine > 1e-12 else 2.0
    return x * stretch, y * stretch, z * stretch


@compiled
def rotation_matrix(x: float, y: float, z: float, r: np.ndarray) -> None:
    """Write the rotation matrix [3, 3] of a rotation vector [rad]."""
    square = x * x + y * y + z * z
    if square < 1e-8:
        f, g = 1.0 - square / 6.0, 0.5 - square / 24.0
    else:
        angle = math.sqrt(square)
        f, g = math.sin(angle) / angle, (1.0 - math.cos(angle)) / square
    r[0, 0], r[1, 1], r[2, 2] = (
        1.0 - g * (y * y + z * z),
        1.0 - g * (x * x + z * z),
        1.0 - g * (x * x + y * y),
    )
    r[0, 1], r[1, 0] = g * x * y - f * z, g * x * y + f * z
    r[0, 2], r[2, 0] = g * x * z + f * y, g * x * z - f * y
    r[1, 2], r[2, 1] = g * y * z - f * x, g * y * z + f * x


@compiled
def rotation_rate(
    x: float, y: float, z: float, xdot: float, ydot: float, zdot: float
) -> tuple[float, float, float]:
    """Return the angular velocity, in the fixed axes, of a rotation vector with a given rate."""
    square = x * x + y * y + z * z
    if square < 1e-8:
        g, h = 0.5 - square / 24.0, 1.0 / 6.0 - square / 120.0
    else:
        angle = math.sqrt(square)
        g, h = (1.0 - math.cos(angle)) / square, (angle - math.sin(angle)) / (square * angle)
    ax, ay, az = crossed(x, y, z, xdot, ydot, zdot)
    bx, by, bz = crossed(x, y, z, ax, ay, az)
    return xdot + g * ax + h * bx, ydot + g * ay + h * by, zdot + g * az + h * bz


@compiled
def compose(A: np.ndarray, B: np.ndarray, out: np.ndarray) -> None:
    """Write the product of two pose rows [12]; `out` must be another array than A and B."""
    for k in range(3):
        out[3 * k], out[3 * k + 1], out[3 * k + 2] = turned(A, B[3 * k], B[3 * k + 1], B[3 * k + 2])
    x, y, z = turned(A, B[9], B[10], B[11])
    out[9], out[10], out[11] = A[9] + x, A[10] + y, A[11] + z


@inlined
def quaternion_matrix(x: float, y: float, z: float, w: float, T: np.ndarray) -> None:
    """Write the rotation of a quaternion xyzw into a pose row; it may be off unit length."""
    two = 2.0 / (x * x + y * y + z * z + w * w)
    T[0], T[1], T[2] = 1.0 - two * (y * y + z * z), two * (x * y + w * z), two * (x * z - w * y)
    T[3], T[4], T[5] = two * (x * y - w * z), 1.0 - two * (x * x + z * z), two * (y * z + w * x)
    T[6], T[7], T[8] = two * (x * z + w * y), two * (y * z - w * x), 1.0 - two * (x * x + y * y)
