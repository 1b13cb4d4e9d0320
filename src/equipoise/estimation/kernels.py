"""What the estimator computes each tick, compiled: steps of the filter, wrenches of frames.

A state of the filter is one array: rotation [9, by rows], velocity, position, places of the feet,
biases of rate and acceleration. Its error is the same with three numbers for the rotation, so that
part e of it, other than the rotation, stands at e + 6 of the state. By rows a rotation is the
transpose of one in a pose row, and `turned_back` multiplies by it.
"""

from __future__ import annotations

import math

import numpy as np

from equipoise.compiled import compiled, entrance, scratch, scratch_matrix
from equipoise.compiled.workspace import integers, matrix, part_of, vector
from equipoise.kinematics.kernels import FRAMES, Q, frame_rows, place_frames, place_joints
from equipoise.kinematics.tree import FRAME_JOINT
from equipoise.spatial.kernels import (
    crossed,
    rotation_matrix,
    rotation_rate,
    rotation_vector,
    turned_back,
)

GRAVITY = 9.81  # [m/s^2]
V_, P_, FEET = 3, 6, 9  # where parts of the error begin
# entries of the noise, as in `FilterNoise`
RATE, ACCELERATION, RATE_BIAS, ACCELERATION_BIAS, SLIP, PLACE, ANGLE = range(7)


@compiled
def turn_all(r: np.ndarray, R: np.ndarray) -> None:
    """Multiply a rotation, by rows [9], from the left by r [3, 3]."""
    for k in range(3):
        x, y, z = R[k], R[3 + k], R[6 + k]
        for i in range(3):
            R[3 * i + k] = r[i, 0] * x + r[i, 1] * y + r[i, 2] * z


@compiled
def write_skew(a: np.ndarray, at: int, A: np.ndarray, row: int, column: int) -> None:
    """Write the matrix of `a x`, of a[at : at + 3], into a block of A."""
    x, y, z = a[at], a[at + 1], a[at + 2]
    A[row, column + 1], A[row, column + 2] = -z, y
    A[row + 1, column], A[row + 1, column + 2] = z, -x
    A[row + 2, column], A[row + 2, column + 1] = -y, x


@compiled
def write_rate(x: np.ndarray, A: np.ndarray) -> None:
    """Write the matrix A [n, n] of `d xi/dt = A xi` at a state."""
    n = A.shape[0]
    A[:, :] = 0.0
    of_rate, of_acceleration = n - 6, n - 3
    A[V_, 1], A[V_ + 1, 0] = GRAVITY, -GRAVITY  # gravity x
    for i in range(3):
        A[P_ + i, V_ + i] = 1.0
        for k in range(3):
            A[i, of_rate + k] = A[V_ + i, of_acceleration + k] = -x[3 * i + k]
    for part in range(V_, n - 6, 3):
        for k in range(3):
            cx, cy, cz = crossed(x[part + 6], x[part + 7], x[part + 8], x[k], x[3 + k], x[6 + k])
            A[part, of_rate + k], A[part + 1, of_rate + k] = -cx, -cy
            A[part + 2, of_rate + k] = -cz


@entrance
def error_rate(x: np.ndarray, A: np.ndarray) -> None:
    """Write the matrix A [n, n] of `d xi/dt = A xi` at a state."""
    write_rate(x, A)


@compiled
def add_noise(x: np.ndarray, P: np.ndarray, dt: float, noise: np.ndarray) -> None:
    """Add what the noise of `dt` brings. That of the unit is alike in all axes: R cancels out."""
    n = P.shape[0]
    of_rate = dt * noise[RATE] ** 2
    G = scratch_matrix(n, 3)
    G[:, :] = 0.0
    for i in range(3):
        G[i, i] = 1.0
    for part in range(V_, n - 6, 3):
        write_skew(x, part + 6, G, part, 0)
    for i in range(n - 6):
        for k in range(n - 6):
            P[i, k] += of_rate * (G[i, 0] * G[k, 0] + G[i, 1] * G[k, 1] + G[i, 2] * G[k, 2])
    for i in range(3):
        P[V_ + i, V_ + i] += dt * noise[ACCELERATION] ** 2
        P[n - 6 + i, n - 6 + i] += dt * noise[RATE_BIAS] ** 2
        P[n - 3 + i, n - 3 + i] += dt * noise[ACCELERATION_BIAS] ** 2
    for i in range(FEET, n - 6):
        P[i, i] += dt * noise[SLIP] ** 2


@entrance
def predict(x: np.ndarray, P: np.ndarray, imu: np.ndarray, dt: float, noise: np.ndarray) -> None:
    """Move state and variance [n, n] on by `dt`; `imu` [6] is rate and acceleration, biased."""
    n = P.shape[0]
    A, moved = scratch_matrix(n, n), scratch_matrix(n, n)
    write_rate(x, A)
    add_noise(x, P, dt, noise)
    for i in range(n):  # (I + dt A) P
        for j in range(n):
            moved[i, j] = P[i, j]
        for k in range(n):
            a = dt * A[i, k]
            if a != 0.0:
                for j in range(n):
                    moved[i, j] += a * P[k, j]
    for i in range(n):  # times (I + dt A)'
        for j in range(n):
            P[i, j] = moved[i, j]
    for j in range(n):
        for k in range(n):
            a = dt * A[j, k]
            if a != 0.0:
                for i in range(n):
                    P[i, j] += a * moved[i, k]
    for i in range(n):
        for j in range(i):
            P[i, j] = P[j, i] = 0.5 * (P[i, j] + P[j, i])
    biases = x.shape[0] - 6
    ax, ay, az = turned_back(
        x, imu[3] - x[biases + 3], imu[4] - x[biases + 4], imu[5] - x[biases + 5]
    )
    az -= GRAVITY
    half = 0.5 * dt * dt
    x[12], x[13], x[14] = (
        x[12] + dt * x[9] + half * ax, x[13] + dt * x[10] + half * ay,
        x[14] + dt * x[11] + half * az,
    )  # fmt: skip
    x[9], x[10], x[11] = x[9] + dt * ax, x[10] + dt * ay, x[11] + dt * az
    turn, own = scratch_matrix(3, 3), scratch(3)
    rotation_matrix(
        dt * (imu[0] - x[biases]), dt * (imu[1] - x[biases + 1]), dt * (imu[2] - x[biases + 2]),
        turn,
    )  # fmt: skip
    for i in range(3):  # R turn
        for k in range(3):
            own[k] = x[3 * i] * turn[0, k] + x[3 * i + 1] * turn[1, k] + x[3 * i + 2] * turn[2, k]
        x[3 * i], x[3 * i + 1], x[3 * i + 2] = own[0], own[1], own[2]


@entrance
def look(x: np.ndarray, soles: np.ndarray, anchors: np.ndarray, z: np.ndarray) -> None:
    """Write by how much what the joints say differs from the state: z [6 l].

    `soles` [l, 12] are pose rows seen from the base, `anchors` [l, 9] rotations of where they stand
    (by columns).
    """
    look_at(x, soles, anchors, z)


@compiled
def look_at(x: np.ndarray, soles: np.ndarray, anchors: np.ndarray, z: np.ndarray) -> None:
    """Write z: by foot its place [m] and its turn [rad], in world axes."""
    r, T = scratch_matrix(3, 3), scratch(9)
    for foot in range(soles.shape[0]):
        at, sole, anchor = 6 * foot, soles[foot], anchors[foot]
        px, py, pz = turned_back(x, sole[9], sole[10], sole[11])
        of = 15 + 3 * foot
        z[at] = px + x[12] - x[of]
        z[at + 1] = py + x[13] - x[of + 1]
        z[at + 2] = pz + x[14] - x[of + 2]
        for k in range(3):
            T[3 * k], T[3 * k + 1], T[3 * k + 2] = turned_back(
                x, sole[3 * k], sole[3 * k + 1], sole[3 * k + 2]
            )
        for i in range(3):
            for k in range(3):
                r[i, k] = T[i] * anchor[k] + T[3 + i] * anchor[3 + k] + T[6 + i] * anchor[6 + k]
        z[at + 3], z[at + 4], z[at + 5] = rotation_vector(r)


@entrance
def correct(
    x: np.ndarray, P: np.ndarray, soles: np.ndarray, anchors: np.ndarray, noise: np.ndarray
) -> None:
    """Take in where the soles are, seen from the base, and how they are turned.

    Their errors are independent, so that one number after the other is taken in.
    """
    n, count = P.shape[0], 6 * soles.shape[0]
    z, xi, seen = scratch(count), scratch(n), scratch(n)
    look_at(x, soles, anchors, z)
    xi[:] = 0.0
    for m in range(count):
        foot, axis = m // 6, m % 6
        first, less, spread = axis - 3, -1, noise[ANGLE]
        if axis < 3:
            first, less, spread = P_ + axis, FEET + 3 * foot + axis, noise[PLACE]
        found = z[m] - xi[first]
        for j in range(n):
            seen[j] = P[first, j]
        if less >= 0:
            found += xi[less]
            for j in range(n):
                seen[j] -= P[less, j]
        variance = seen[first] + spread * spread
        if less >= 0:
            variance -= seen[less]
        for i in range(n):
            gain = seen[i] / variance
            xi[i] += gain * found
            for j in range(n):
                P[i, j] -= gain * seen[j]
    for i in range(n):
        xi[i] = -xi[i]
    move_by(x, xi)


@compiled
def move_by(x: np.ndarray, xi: np.ndarray) -> None:
    """Multiply the state from the left by the exponential of an error [n]."""
    n, turn = xi.shape[0], scratch_matrix(3, 3)
    rotation_matrix(xi[0], xi[1], xi[2], turn)
    turn_all(turn, x)
    for part in range(V_, n - 6, 3):
        a, b, c = x[part + 6], x[part + 7], x[part + 8]
        dx, dy, dz = rotation_rate(xi[0], xi[1], xi[2], xi[part], xi[part + 1], xi[part + 2])
        x[part + 6] = turn[0, 0] * a + turn[0, 1] * b + turn[0, 2] * c + dx
        x[part + 7] = turn[1, 0] * a + turn[1, 1] * b + turn[1, 2] * c + dy
        x[part + 8] = turn[2, 0] * a + turn[2, 1] * b + turn[2, 2] * c + dz
    for i in range(n - 6, n):
        x[i + 6] += xi[i]


@entrance
def move(x: np.ndarray, xi: np.ndarray) -> None:
    """Multiply the state from the left by the exponential of an error [n]."""
    move_by(x, xi)


@entrance
def rows_of_frames(
    floats: np.ndarray, whole: np.ndarray, tables: np.ndarray, q: np.ndarray, J: np.ndarray
) -> None:
    """Place all at q and write the rows of the frames, six for each, to the first of J [m, nv].

    Part 0 is the tree, 1 the state. J is zero where no joint moves its frame.
    """
    tree, state = part_of(floats, whole, tables, 0), part_of(floats, whole, tables, 1)
    own = vector(state, Q)
    for i in range(q.shape[0]):
        own[i] = q[i]
    place_joints(tree, state)
    place_frames(tree, state)
    frames, joint = matrix(state, FRAMES), integers(tree, FRAME_JOINT)
    if 6 * frames.shape[0] <= J.shape[0]:
        for f in range(frames.shape[0]):
            frame_rows(tree, state, joint[f], frames[f], J, 6 * f)


@entrance
def least_wrenches(J: np.ndarray, r: np.ndarray, alike: float, w: np.ndarray) -> None:
    """Write the w [m] with the least `|J' w - r|`; of rows that are alike the least w.

    Rows that differ by less than `alike`, a share of their mean square, are not told apart.
    """
    m, nv = J.shape
    G, total = scratch_matrix(m, m), 0.0
    for i in range(m):
        for k in range(i + 1):
            one = 0.0
            for c in range(nv):
                one += J[i, c] * J[k, c]
            G[i, k] = one
        total += G[i, i]
        one = 0.0
        for c in range(nv):
            one += J[i, c] * r[c]
        w[i] = one
    for i in range(m):  # Cholesky; the diagonal holds inverses
        G[i, i] += alike * total / m
        for k in range(i + 1):
            one = G[i, k]
            for c in range(k):
                one -= G[i, c] * G[k, c]
            G[i, k] = 1.0 / math.sqrt(one) if i == k else one * G[k, k]
    for i in range(m):
        for c in range(i):
            w[i] -= G[i, c] * w[c]
        w[i] *= G[i, i]
    for i in range(m - 1, -1, -1):
        for c in range(i + 1, m):
            w[i] -= G[c, i] * w[c]
        w[i] *= G[i, i]
