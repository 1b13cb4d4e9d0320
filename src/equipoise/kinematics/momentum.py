"""Momentum of the whole robot about the origin of the world: its rows, and what changes it.

A twist is the velocity of the point at the origin of the world and an angular velocity, a momentum
the linear one and that about the origin. Both are then of one form for all bodies, and add up.
"""

from __future__ import annotations

import numpy as np

from equipoise.compiled import compiled, scratch
from equipoise.compiled.workspace import Block, integers, matrix, vector
from equipoise.kinematics.kernels import (
    ACCELERATIONS,
    COLUMNS,
    JOINTS,
    MOMENTS,
    MOMENTUM_RATE,
    SPINS,
    VELOCITIES,
)
from equipoise.kinematics.tree import BELOW, INERTIA, MASS, PARENT
from equipoise.spatial.kernels import crossed, turned


@compiled
def weigh_turning(tree: Block, state: Block) -> None:
    """Write `spins`, the inertia about the origin of what each joint moves with, and the rate.

    `momentum_rate` is the rate of the whole momentum at zero dv/dt. Centre of mass and motion of
    the state have to be there.
    """
    joints, spins, rate = matrix(state, JOINTS), matrix(state, SPINS), vector(state, MOMENTUM_RATE)
    mass, inertia, parent = matrix(tree, MASS), matrix(tree, INERTIA), integers(tree, PARENT)
    speed, drift = matrix(state, VELOCITIES), matrix(state, ACCELERATIONS)
    moment, p, dp = scratch(3), scratch(6), scratch(6)
    count = joints.shape[0]
    spins[0, :] = 0.0
    rate[:] = 0.0
    for j in range(1, count):
        m, T = mass[j, 0], joints[j]
        x, y, z = turned(T, mass[j, 1], mass[j, 2], mass[j, 3])
        x, y, z = T[9] + x, T[10] + y, T[11] + z
        moment[0], moment[1], moment[2] = m * x, m * y, m * z
        turn_inertia(T, inertia[j], spins[j])
        square = x * x + y * y + z * z
        for i in range(3):
            spins[j, 4 * i] += m * square
        add_outer(spins[j], -m, x, y, z)
        momentum_of(m, moment, spins[j], speed[j], p)
        momentum_of(m, moment, spins[j], drift[j], dp)
        v = speed[j]
        fx, fy, fz = crossed(v[3], v[4], v[5], p[0], p[1], p[2])
        nx, ny, nz = crossed(v[3], v[4], v[5], p[3], p[4], p[5])
        ox, oy, oz = crossed(v[0], v[1], v[2], p[0], p[1], p[2])
        rate[0] += dp[0] + fx
        rate[1] += dp[1] + fy
        rate[2] += dp[2] + fz
        rate[3] += dp[3] + nx + ox
        rate[4] += dp[4] + ny + oy
        rate[5] += dp[5] + nz + oz
    for j in range(count - 1, 0, -1):
        for i in range(9):
            spins[parent[j], i] += spins[j, i]


@compiled
def turn_inertia(T: np.ndarray, own: np.ndarray, out: np.ndarray) -> None:
    """Write R I R^T of a pose row T and an inertia [9] in its axes."""
    half = scratch(9)
    for i in range(3):  # columns of R I, which is the same as rows of I R^T
        half[3 * i], half[3 * i + 1], half[3 * i + 2] = turned(
            T, own[3 * i], own[3 * i + 1], own[3 * i + 2]
        )
    for a in range(3):
        for b in range(3):
            out[3 * a + b] = half[a] * T[b] + half[3 + a] * T[3 + b] + half[6 + a] * T[6 + b]


@compiled
def add_outer(out: np.ndarray, factor: float, x: float, y: float, z: float) -> None:
    """Add factor times (x, y, z) (x, y, z)^T to a matrix [9]."""
    out[0] += factor * x * x
    out[1] += factor * x * y
    out[2] += factor * x * z
    out[3] += factor * y * x
    out[4] += factor * y * y
    out[5] += factor * y * z
    out[6] += factor * z * x
    out[7] += factor * z * y
    out[8] += factor * z * z


@compiled
def momentum_of(
    m: float, moment: np.ndarray, spin: np.ndarray, twist: np.ndarray, out: np.ndarray
) -> None:
    """Write the momentum [6] of a mass with a moment [3] and an inertia [9] about the origin."""
    x, y, z = crossed(twist[3], twist[4], twist[5], moment[0], moment[1], moment[2])
    out[0], out[1], out[2] = m * twist[0] + x, m * twist[1] + y, m * twist[2] + z
    x, y, z = crossed(moment[0], moment[1], moment[2], twist[0], twist[1], twist[2])
    out[3] = x + spin[0] * twist[3] + spin[1] * twist[4] + spin[2] * twist[5]
    out[4] = y + spin[3] * twist[3] + spin[4] * twist[4] + spin[5] * twist[5]
    out[5] = z + spin[6] * twist[3] + spin[7] * twist[4] + spin[8] * twist[5]


@compiled
def momentum_column(tree: Block, state: Block, joint: int, c: int, out: np.ndarray) -> None:
    """Write the momentum [6] that a joint's own column c gives to what hangs on it."""
    momentum_of(
        vector(tree, BELOW)[joint], matrix(state, MOMENTS)[joint], matrix(state, SPINS)[joint],
        matrix(state, COLUMNS)[c], out,
    )  # fmt: skip
