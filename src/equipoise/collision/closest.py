"""Kernels of closest points between the cores of two convex shapes.

A segment against a segment or a box has closed forms. Anything else goes by the method of Gilbert,
Johnson and Keerthi: the point of the difference of both shapes that is nearest to the origin is
found over growing simplices of support points. Source: Gilbert, Johnson, Keerthi 1988; Ericson,
Real-Time Collision Detection, 2005, chapters 5 and 9 for the nearest point of a simplex.
"""

from __future__ import annotations

import math

import numpy as np

from equipoise.collision.shapes import BOX, CYLINDER, SEGMENT
from equipoise.compiled import compiled, inlined, scratch, scratch_matrix
from equipoise.spatial.kernels import turned, turned_back

TOUCHING = 1e-9  # [m] cores closer than this have no direction between them
STEPS = 64
ACCURACY = 1e-11  # share of the squared distance by which the last step may still gain


@inlined
def slope_at(p: np.ndarray, u: np.ndarray, half: np.ndarray, s: float) -> float:
    """Return half the slope of the squared distance between p + s u and a box [3]."""
    total = 0.0
    for i in range(3):
        x = p[i] + s * u[i]
        if x > half[i]:
            total += u[i] * (x - half[i])
        elif x < -half[i]:
            total += u[i] * (x + half[i])
    return total


@compiled
def segment_to_box(
    A: np.ndarray,
    length: float,
    B: np.ndarray,
    half: np.ndarray,
    on_a: np.ndarray,
    on_b: np.ndarray,
) -> None:
    """Write the closest points, in world axes, of a segment along z of A and a box at B.

    The squared distance along the segment is convex, with a slope that is piecewise linear: its
    root lies between two of at most six kinks.
    """
    p, u = scratch(3), scratch(3)
    p[0], p[1], p[2] = turned_back(B, A[9] - B[9], A[10] - B[10], A[11] - B[11])
    u[0], u[1], u[2] = turned_back(B, A[6], A[7], A[8])
    low, high = -length, length
    for i in range(3):
        if abs(u[i]) > 1e-14:
            for side in range(2):
                bound = half[i] if side == 0 else -half[i]
                kink = (bound - p[i]) / u[i]
                if low < kink < high:
                    if slope_at(p, u, half, kink) > 0.0:
                        high = kink
                    else:
                        low = kink
    at_low, at_high = slope_at(p, u, half, low), slope_at(p, u, half, high)
    if at_low >= 0.0:
        s = low
    elif at_high <= 0.0:
        s = high
    else:
        s = low - at_low * (high - low) / (at_high - at_low)
    for i in range(3):
        on_a[i] = A[9 + i] + s * A[6 + i]
        x = p[i] + s * u[i]
        p[i] = min(max(x, -half[i]), half[i])
    x, y, z = turned(B, p[0], p[1], p[2])
    on_b[0], on_b[1], on_b[2] = B[9] + x, B[10] + y, B[11] + z


@compiled
def segment_to_segment(
    A: np.ndarray, length_a: float, B: np.ndarray, length_b: float, on_a: np.ndarray,
    on_b: np.ndarray,
) -> None:  # fmt: skip
    """Write the closest points, in world axes, of two segments along z of A and of B."""
    rx, ry, rz = A[9] - B[9], A[10] - B[10], A[11] - B[11]
    along = A[6] * B[6] + A[7] * B[7] + A[8] * B[8]
    on_first = A[6] * rx + A[7] * ry + A[8] * rz
    on_second = B[6] * rx + B[7] * ry + B[8] * rz
    apart = 1.0 - along * along
    s = 0.0  # parallel segments: any place does, the middle of the first as far as it goes
    if apart > 1e-12:
        s = min(max((along * on_second - on_first) / apart, -length_a), length_a)
    w = along * s + on_second
    if w < -length_b or w > length_b:
        w = min(max(w, -length_b), length_b)
        s = min(max(along * w - on_first, -length_a), length_a)
    for i in range(3):
        on_a[i] = A[9 + i] + s * A[6 + i]
        on_b[i] = B[9 + i] + w * B[6 + i]


@compiled
def support(
    kind: int, size: np.ndarray, points: np.ndarray, T: np.ndarray, d: np.ndarray, out: np.ndarray
) -> None:
    """Write the point of a core at T that is farthest along d [3]."""
    x, y, z = turned_back(T, d[0], d[1], d[2])
    if kind == SEGMENT:
        px, py, pz = 0.0, 0.0, size[0] if z >= 0.0 else -size[0]
    elif kind == BOX:
        px = size[0] if x >= 0.0 else -size[0]
        py = size[1] if y >= 0.0 else -size[1]
        pz = size[2] if z >= 0.0 else -size[2]
    elif kind == CYLINDER:
        across = math.sqrt(x * x + y * y)
        px = py = 0.0
        if across > 0.0:
            px, py = size[0] * x / across, size[0] * y / across
        pz = size[1] if z >= 0.0 else -size[1]
    else:
        best, most = 0, -np.inf
        for k in range(points.shape[0]):
            along = points[k, 0] * x + points[k, 1] * y + points[k, 2] * z
            if along > most:
                best, most = k, along
        px, py, pz = points[best, 0], points[best, 1], points[best, 2]
    wx, wy, wz = turned(T, px, py, pz)
    out[0], out[1], out[2] = T[9] + wx, T[10] + wy, T[11] + wz


@compiled
def closest_by_simplices(
    kind_a: int, size_a: np.ndarray, points_a: np.ndarray, T_a: np.ndarray, kind_b: int,
    size_b: np.ndarray, points_b: np.ndarray, T_b: np.ndarray, on_a: np.ndarray, on_b: np.ndarray,
) -> bool:  # fmt: skip
    """Write the closest points of two cores; return whether they are apart."""
    W, P = scratch_matrix(4, 3), scratch_matrix(4, 3)  # the simplex, and its points on the first
    share, d, p, q = scratch(4), scratch(3), scratch(3), scratch(3)
    for i in range(3):
        d[i] = T_b[9 + i] - T_a[9 + i]
    if d[0] == 0.0 and d[1] == 0.0 and d[2] == 0.0:
        d[0] = 1.0
    count, v, square = 0, scratch(3), np.inf
    v[:] = 0.0
    for step in range(STEPS):
        support(kind_a, size_a, points_a, T_a, d, p)
        for i in range(3):
            d[i] = -d[i]
        support(kind_b, size_b, points_b, T_b, d, q)
        gain, known = 0.0, False
        for i in range(3):
            gain += v[i] * (v[i] - (p[i] - q[i]))
        for k in range(count):
            same = True
            for i in range(3):
                same = same and W[k, i] == p[i] - q[i]
            known = known or same
        if step > 0 and (known or gain <= ACCURACY * square):
            break
        for i in range(3):
            W[count, i], P[count, i] = p[i] - q[i], p[i]
        count = nearest_of_simplex(W, P, count + 1, share)
        before, square = square, 0.0
        for i in range(3):
            v[i] = 0.0
            for k in range(count):
                v[i] += share[k] * W[k, i]
            square += v[i] * v[i]
        if count == 4 or square < TOUCHING * TOUCHING:
            return False
        if square >= before:  # no digits left to gain
            break
        for i in range(3):
            d[i] = -v[i]
    for i in range(3):
        on_a[i] = 0.0
        for k in range(count):
            on_a[i] += share[k] * P[k, i]
        on_b[i] = on_a[i] - v[i]
    return True


@compiled
def nearest_of_simplex(W: np.ndarray, P: np.ndarray, count: int, share: np.ndarray) -> int:
    """Reduce a simplex [4, 3] of `count` corners to those that carry its point nearest to zero.

    Write their shares; P is rearranged with W. Return their number: 4 if zero lies inside. The last
    corner is new; each of the sub-simplices with it is tried, and the one kept whose shares are
    positive and whose point is nearest.
    """
    best, least = scratch(4), np.inf
    trial = scratch(4)
    found = 0
    for mask in range(1, 1 << count):
        if not solve_shares(W, count, mask, trial):
            continue
        square = 0.0
        for i in range(3):
            x = 0.0
            for k in range(count):
                x += trial[k] * W[k, i]
            square += x * x
        if square < least * (1.0 - 1e-14):
            least, found = square, mask
            for k in range(count):
                best[k] = trial[k]
    kept = 0
    for k in range(count):
        if found & (1 << k):
            for i in range(3):
                W[kept, i], P[kept, i] = W[k, i], P[k, i]
            share[kept] = best[k]
            kept += 1
    return kept


@compiled
def solve_shares(W: np.ndarray, count: int, mask: int, share: np.ndarray) -> bool:
    """Write the shares of the corners in `mask` whose affine hull is nearest to zero.

    Return whether all are positive and the corners are not degenerate.
    """
    for k in range(count):
        share[k] = 0.0
    first, n = -1, 0
    E, names = scratch_matrix(3, 3), scratch(3)
    for k in range(count):
        if mask & (1 << k):
            if first < 0:
                first = k
            else:
                for i in range(3):
                    E[n, i] = W[k, i] - W[first, i]
                names[n] = k
                n += 1
    if n == 0:
        share[first] = 1.0
        return True
    G, b = scratch_matrix(3, 3), scratch(3)
    for i in range(n):
        b[i] = -(E[i, 0] * W[first, 0] + E[i, 1] * W[first, 1] + E[i, 2] * W[first, 2])
        for k in range(n):
            G[i, k] = E[i, 0] * E[k, 0] + E[i, 1] * E[k, 1] + E[i, 2] * E[k, 2]
    for k in range(n):  # elimination of a positive definite matrix needs no pivots
        if not G[k, k] > 1e-14 * (E[k, 0] ** 2 + E[k, 1] ** 2 + E[k, 2] ** 2):
            return False
        for i in range(k + 1, n):
            factor = G[i, k] / G[k, k]
            b[i] -= factor * b[k]
            for c in range(k + 1, n):
                G[i, c] -= factor * G[k, c]
    total = 1.0
    for k in range(n - 1, -1, -1):
        for c in range(k + 1, n):
            b[k] -= G[k, c] * b[c]
        b[k] /= G[k, k]
        share[int(names[k])] = b[k]
        total -= b[k]
        if not b[k] > 0.0:
            return False
    share[first] = total
    return total > 0.0
