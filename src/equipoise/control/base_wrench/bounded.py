"""Supporting forces that a floor can give: the base wrench shared out by a small QP.

Among all F with `J_b^T F = u_b` the one is taken whose predicted reaction `lam_0 + F` presses,
stays in the friction cones, keeps its centres of pressure in the soles, and costs least. What
cannot be kept is broken by one slack [N], which is reported. Geometry only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import daqp
import numpy as np
import scipy.linalg

from equipoise.contacts import SoleContact
from equipoise.spatial import Array

_SIDES = 8
_PENALTY = 1e5
_NO_BOUND = 1e30
_OPTIMAL_FLAGS = (1, 2)


@dataclass(frozen=True)
class ReactionBounds:
    """How far from the edge a predicted reaction is kept.

    `normal_min` [N] on each sole; `friction_share` of the cone; `pressure_margin` [m] of the
    centre of pressure to the edges; `warn` [N]: how close to a bound a sole is reported.
    """

    normal_min: float = 10.0
    friction_share: float = 0.9
    pressure_margin: float = 0.005
    warn: float = 10.0


class DistributionStatus(Enum):
    """How the distribution went; the value is a sentence."""

    POSSIBLE = "the floor can give the predicted reaction"
    SLACK = "no distribution keeps every bound; the least violation was taken"
    FAILED = "the QP gave no answer; the least costly distribution was taken"


@dataclass(frozen=True)
class Distribution:
    """`F` (k,), the predicted reaction (k,), the slack [N], and soles near an edge, in words."""

    F: Array
    predicted: Array
    slack: float
    status: DistributionStatus
    warnings: tuple[str, ...]


@dataclass(frozen=True)
class _Rows:
    """`A lam >= b` (m,), in newtons, with what happens to the sole if a row is broken."""

    A: Array
    b: Array
    what: tuple[str, ...]


class BoundedDistribution:
    """Distributes over given soles; build it once."""

    def __init__(self, soles: Sequence[SoleContact], bounds: ReactionBounds | None = None) -> None:
        self.soles = tuple(soles)
        self.bounds = bounds or ReactionBounds()
        parts = [_rows_of(sole, self.bounds) for sole in self.soles]
        self._A = scipy.linalg.block_diag(*(part.A for part in parts))
        self._b = np.concatenate([part.b for part in parts])
        self._what = [w for part in parts for w in part.what]
        self._costs = np.concatenate([sum(sole.reaction_costs()) for sole in self.soles])

    def __call__(self, u_base: Array, J_base: Array, lam_0: Array) -> Distribution:
        """Return the distribution of `u_base` (6,) over the rows of `J_base` (k, 6).

        `lam_0` (k,) is the reaction that would act with F = 0.
        """
        G = J_base.T
        predicted = self._least(u_base + G @ lam_0, G)
        N = scipy.linalg.null_space(G)
        z, slack, solved = self._solve(predicted, N)
        predicted = predicted + N @ z
        status = DistributionStatus.POSSIBLE
        if not solved:
            status = DistributionStatus.FAILED
        elif slack > 1e-3:
            status = DistributionStatus.SLACK
        return Distribution(predicted - lam_0, predicted, slack, status, self._warnings(predicted))

    def _least(self, wanted: Array, G: Array) -> Array:
        """Return the least costly reaction (k,) that carries `wanted` (6,)."""
        inverse_squares = 1.0 / (self._costs * self._costs)
        GW = G * inverse_squares
        return GW.T @ np.linalg.solve(GW @ G.T, wanted)

    def _solve(self, least: Array, N: Array) -> tuple[Array, float, bool]:
        """Return z (m,) of `least + N z`, the slack and whether the QP was solved."""
        m = N.shape[1]
        room = self._A @ least - self._b
        if room.min() >= 0.0 or m == 0:
            return np.zeros(m), max(0.0, -float(room.min())), True
        weighted = self._costs[:, None] * N
        H = np.zeros((m + 1, m + 1))
        H[:m, :m], H[m, m] = weighted.T @ weighted, 1.0
        f = np.append(weighted.T @ (self._costs * least), _PENALTY)
        A = np.column_stack((self._A @ N, np.ones(len(self._b))))
        A = np.vstack((A, np.eye(m + 1)[m:]))
        lower = np.append(-room, 0.0)
        x, _, flag, _ = daqp.solve(
            H, f, A, np.full(len(lower), _NO_BOUND), lower, np.zeros(len(lower), dtype=np.int32)
        )
        x = np.array(x)
        if flag not in _OPTIMAL_FLAGS or not np.isfinite(x).all():
            return np.zeros(m), max(0.0, -float(room.min())), False
        return x[:m], float(max(0.0, -(room + self._A @ (N @ x[:m])).min())), True

    def _warnings(self, predicted: Array) -> tuple[str, ...]:
        room = self._A @ predicted - self._b
        near = {self._what[k] for k in np.flatnonzero(room < self.bounds.warn)}
        return tuple(sorted(near))


def _rows_of(sole: SoleContact, bounds: ReactionBounds) -> _Rows:
    """Return the rows of one sole on its wrench (6,) in the axes of the sole."""
    s, friction = sole.sole, bounds.friction_share * sole.friction
    name = sole.name
    rows, offsets, what = [[0.0, 0.0, 1.0, 0.0, 0.0, 0.0]], [bounds.normal_min], [f"{name} lifts"]

    def add(row: Sequence[float], sentence: str) -> None:
        rows.append(list(row))
        offsets.append(0.0)
        what.append(f"{name} {sentence}")

    reach = friction * np.cos(np.pi / _SIDES)
    for angle in 2.0 * np.pi * np.arange(_SIDES) / _SIDES:
        add((-np.cos(angle), -np.sin(angle), reach, 0.0, 0.0, 0.0), "slips")
    m = bounds.pressure_margin
    half_x, half_y = 0.5 * (s.x_max - s.x_min), 0.5 * (s.y_max - s.y_min)
    x, y = 1.0 / half_x, 1.0 / half_y
    add((0, 0, (s.x_max - m) * x, 0, x, 0), "tips over its front edge")
    add((0, 0, -(s.x_min + m) * x, 0, -x, 0), "tips over its rear edge")
    add((0, 0, (s.y_max - m) * y, -y, 0, 0), "tips over its left edge")
    add((0, 0, -(s.y_min + m) * y, y, 0, 0), "tips over its right edge")
    for row in _yaw_rows(sole, friction):
        add(row, "turns")
    return _Rows(np.array(rows, dtype=float), np.array(offsets), tuple(what))


def _yaw_rows(sole: SoleContact, friction: float) -> list[Array]:
    """Return the eight rows that bound the yaw moment (see `contacts.reaction_margins`)."""
    s = sole.sole
    half_x, half_y = 0.5 * (s.x_max - s.x_min), 0.5 * (s.y_max - s.y_min)
    centre_x, centre_y = 0.5 * (s.x_max + s.x_min), 0.5 * (s.y_max + s.y_min)
    fx, fy, fz, mx, my, mz = np.eye(6)
    mx_c, my_c = mx - centre_y * fz, my + centre_x * fz
    mz_c = mz - (centre_x * fy - centre_y * fx)
    reach = friction * (half_x + half_y)
    rows = []
    for turn in (1.0, -1.0):
        across, along = half_y * fx + turn * friction * mx_c, half_x * fy + turn * friction * my_c
        for a in (1.0, -1.0):
            for b in (1.0, -1.0):
                rows.append((reach * fz - a * across - b * along - turn * mz_c) / reach)
    return rows
