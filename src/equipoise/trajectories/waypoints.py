"""Minimum jerk through timed waypoints in SE(3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pinocchio as pin

from equipoise.compiled import compiled, entrance, scratch, scratch_matrix
from equipoise.errors import InputError
from equipoise.spatial import Array, pose_row
from equipoise.spatial.kernels import rotation_matrix, rotation_rate, turned
from equipoise.trajectories.base import ROW, WAYPOINTS, CompiledTrajectory
from equipoise.trajectories.quintic import quintic_powers

POWERS = 6  # of a quintic
PIECES = 27  # where the starts of the pieces begin among the numbers


@dataclass(frozen=True)
class Waypoint:
    """A pose to be reached at time `t` [s]; with `stop` the motion comes to rest there."""

    t: float
    T_world_target: pin.SE3
    stop: bool = False


class WaypointTrajectory(CompiledTrajectory):
    """Minimum jerk through waypoints: at rest at both ends and at those marked `stop`.

    Between rests, position and rotation vector (relative to the first waypoint) are the quintic
    spline through the waypoints, which minimises the integral of the squared third derivative.
    Before the first waypoint and after the last the pose is held.
    `numbers`: first and last time, number n of pieces, first and last pose row, where pieces start
    (n,), their powers (n, 6, 6), highest first.
    """

    kind = WAYPOINTS
    numbers: Array = np.zeros(0)

    def __init__(self, waypoints: Sequence[Waypoint]) -> None:
        if not waypoints:
            raise InputError("a trajectory needs at least one waypoint")
        times = [w.t for w in waypoints]
        if not np.isfinite(times).all() or any(np.diff(times) <= 0.0):
            raise InputError("waypoint times must increase", given=times)
        self.waypoints = tuple(waypoints)
        first_time = float(times[0])
        coordinates = self._coordinates()
        if not np.isfinite(coordinates).all():
            raise InputError("waypoints must be finite", given=coordinates.tolist())
        held = np.zeros((1, 6, 6))  # powers of a pose that stays
        held[0, 5] = coordinates[0]
        pieces = [
            quintic_powers(np.array(times[a : b + 1]), coordinates[a : b + 1])
            for a, b in self._rests()
        ]
        starts, powers = [first_time, *times[:-1]], np.concatenate([held, *pieces])
        self.numbers = np.concatenate(
            (
                [first_time, times[-1], len(starts)],
                pose_row(waypoints[0].T_world_target),
                pose_row(waypoints[-1].T_world_target),
                starts,
                powers.ravel(),
            )
        )

    def _coordinates(self) -> Array:
        rows = []
        R_start = self.waypoints[0].T_world_target.rotation
        previous = np.zeros(3)
        for w in self.waypoints:
            rotation = pin.log3(R_start.T @ w.T_world_target.rotation)
            rotation = _nearest_branch(rotation, previous)
            previous = rotation
            rows.append(np.concatenate((w.T_world_target.translation, rotation)))
        return np.array(rows)

    def _rests(self) -> list[tuple[int, int]]:
        last = len(self.waypoints) - 1
        rests = [0, *(i for i, w in enumerate(self.waypoints) if w.stop and 0 < i < last), last]
        return list(pairwise(rests)) if last > 0 else []

    def row(self, t: float) -> Array:
        """Return pose row and twist (18,) at time `t` [s]."""
        row = np.empty(ROW)
        waypoints_alone(self.numbers, float(t), row)
        return row


@compiled
def waypoint_row(numbers: np.ndarray, t: float, row: np.ndarray) -> None:
    """Write pose row and twist [18] at time t; see `WaypointTrajectory.numbers`."""
    count = int(numbers[2])
    if t <= numbers[0] or t >= numbers[1]:
        first = 3 if t <= numbers[0] else 15
        for i in range(12):
            row[i] = numbers[first + i]
        for i in range(12, 18):
            row[i] = 0.0
        return
    k = count - 1
    while k > 0 and numbers[PIECES + k] > t:
        k -= 1
    since, at = t - numbers[PIECES + k], PIECES + count + k * POWERS * 6
    x, rate = scratch(6), scratch(6)
    x[:] = 0.0
    rate[:] = 0.0
    for power in range(POWERS):
        for i in range(6):
            rate[i] = rate[i] * since + x[i]
            x[i] = x[i] * since + numbers[at + 6 * power + i]
    turn, T_start = scratch_matrix(3, 3), numbers[3:15]
    rotation_matrix(x[3], x[4], x[5], turn)
    for i in range(3):
        row[9 + i], row[12 + i] = x[i], rate[i]
        column = turned(T_start, turn[0, i], turn[1, i], turn[2, i])
        row[3 * i], row[3 * i + 1], row[3 * i + 2] = column
    wx, wy, wz = rotation_rate(x[3], x[4], x[5], rate[3], rate[4], rate[5])
    row[15], row[16], row[17] = turned(T_start, wx, wy, wz)


@entrance
def waypoints_alone(numbers: np.ndarray, t: float, row: np.ndarray) -> None:
    """Write the row of one trajectory."""
    waypoint_row(numbers, t, row)


def _nearest_branch(rotation: Array, previous: Array) -> Array:
    """Return the rotation vector of the same rotation that lies nearest to `previous`."""
    angle = float(np.linalg.norm(rotation))
    if angle < 1e-12:
        return rotation
    axis = rotation / angle
    turns = np.round((axis @ previous - angle) / (2.0 * np.pi))
    return axis * (angle + 2.0 * np.pi * turns)
