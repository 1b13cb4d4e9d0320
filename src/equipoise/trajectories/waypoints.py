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
from equipoise.spatial.numbers import real_number
from equipoise.spatial.poses import rigid
from equipoise.trajectories.base import (
    NEARLY,
    ROW,
    SHORTEST,
    WAYPOINTS,
    CompiledTrajectory,
    instant,
)
from equipoise.trajectories.quintic import powers_between, quintic_powers
from equipoise.trajectories.turns import end_rates, short_turns

POWERS = 6  # of a quintic
AXES = 9  # numbers of the axes in which a piece turns, column by column
PIECES = 27  # where the starts of the pieces begin among the numbers
LATEST = 1e9  # [s]


@dataclass(frozen=True)
class Waypoint:
    """A pose to be reached at time `t` [s]; with `stop` the motion comes to rest there.

    What is no time or no pose is refused by the trajectory.
    """

    t: float
    T_world_target: pin.SE3
    stop: bool = False


class WaypointTrajectory(CompiledTrajectory):
    """Minimum jerk through waypoints: at rest at both ends and at those marked `stop`.

    Between rests the position is the quintic spline through the waypoints, which minimises the
    integral of the squared third derivative. The rotation goes the short way from each waypoint to
    the next, so that a whole turn is turned by giving waypoints on its way; a half turn goes on in
    the sense of the leg before (of the one after, at the start). Where all legs turn about one axis
    the angle is the same spline; otherwise its rates at the waypoints are those of the spline
    through the legs laid end to end, and angular velocity and acceleration are continuous.
    Before the first waypoint and after the last the pose is held.
    `numbers`: first and last time, number n of pieces, first and last pose row, where pieces start
    (n,), the axes they turn in (n, 9), their powers (n, 6, 6), highest first.
    Raises: `InputError`.
    """

    kind = WAYPOINTS
    numbers: Array = np.zeros(0)

    def __init__(self, waypoints: Sequence[Waypoint]) -> None:
        if not len(waypoints):
            raise InputError(
                "a trajectory needs at least one waypoint",
                remedy="A pose that does not move is a `FixedPose`",
            )
        times = np.array([_time_of(w) for w in waypoints])
        if not (np.diff(times) >= NEARLY * SHORTEST).all():
            raise InputError(
                f"waypoint times must increase, by {SHORTEST:g} s at least", given=times.tolist()
            )
        self.waypoints = tuple(waypoints)
        places = np.array([w.T_world_target.translation for w in waypoints])
        rotations = [w.T_world_target.rotation for w in waypoints]
        turns = short_turns(rotations)
        held = np.zeros((1, POWERS, 6))  # powers of a pose that stays
        held[0, -1, :3] = places[0]
        pieces = [held]
        try:
            with np.errstate(all="ignore"):
                for a, b in self._rests():
                    at = times[a : b + 1]
                    moved = quintic_powers(at, places[a : b + 1])
                    pieces.append(np.concatenate((moved, _turning(at, turns[a:b])), axis=2))
        except np.linalg.LinAlgError:
            pieces.append(np.full((1, POWERS, 6), np.nan))
        powers = np.concatenate(pieces)
        if not np.isfinite(powers).all():
            raise InputError(
                "no smooth way goes through these waypoints",
                given=times.tolist(),
                remedy="Give times that are not many orders of magnitude apart",
            )
        axes = [R.T.ravel() for R in (rotations[0], *rotations[:-1])]
        self.numbers = np.concatenate(
            (
                [times[0], times[-1], len(powers)],
                pose_row(waypoints[0].T_world_target),
                pose_row(waypoints[-1].T_world_target),
                [times[0], *times[:-1]],
                np.concatenate(axes),
                powers.ravel(),
            )
        )

    def _rests(self) -> list[tuple[int, int]]:
        last = len(self.waypoints) - 1
        rests = [0, *(i for i, w in enumerate(self.waypoints) if w.stop and 0 < i < last), last]
        return list(pairwise(rests)) if last > 0 else []

    def row(self, t: float) -> Array:
        """Return pose row and twist (18,) at time `t` [s]."""
        row = np.empty(ROW)
        waypoints_alone(self.numbers, instant(t), row)
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
    since, at = t - numbers[PIECES + k], PIECES + count * (1 + AXES) + k * POWERS * 6
    x, rate = scratch(6), scratch(6)
    x[:] = 0.0
    rate[:] = 0.0
    for power in range(POWERS):
        for i in range(6):
            rate[i] = rate[i] * since + x[i]
            x[i] = x[i] * since + numbers[at + 6 * power + i]
    turn, axes = scratch_matrix(3, 3), numbers[PIECES + count + AXES * k :]
    rotation_matrix(x[3], x[4], x[5], turn)
    for i in range(3):
        row[9 + i], row[12 + i] = x[i], rate[i]
        column = turned(axes, turn[0, i], turn[1, i], turn[2, i])
        row[3 * i], row[3 * i + 1], row[3 * i + 2] = column
    wx, wy, wz = rotation_rate(x[3], x[4], x[5], rate[3], rate[4], rate[5])
    row[15], row[16], row[17] = turned(axes, wx, wy, wz)


@entrance
def waypoints_alone(numbers: np.ndarray, t: float, row: np.ndarray) -> None:
    """Write the row of one trajectory."""
    waypoint_row(numbers, t, row)


def _time_of(waypoint: Waypoint) -> float:
    """Return the time [s] of a waypoint. Raises: `InputError` if that or its pose is none."""
    t = real_number("the time of a waypoint", waypoint.t)
    if abs(t) > LATEST:
        raise InputError("a waypoint lies too far away in time", given=t, remedy="Give seconds")
    rigid(f"the pose of the waypoint at t = {t:g} s", waypoint.T_world_target)
    return t


def _turning(times: Array, turns: Array) -> Array:
    """Return the powers (m, 6, 3) of the rotation vectors of the legs between two rests.

    `turns` (m, 3) [rad] are the whole legs; each piece turns in the axes of its own start.
    """
    laid = np.concatenate((np.zeros((1, 3)), np.cumsum(turns, axis=0)))
    spline = quintic_powers(times, laid)
    rates = np.concatenate((spline[:, 4], np.zeros((1, 3))))
    bends = np.concatenate((2.0 * spline[:, 3], np.zeros((1, 3))))
    pieces = []
    for k, (h, turn) in enumerate(zip(np.diff(times), turns, strict=True)):
        start = np.stack((np.zeros(3), rates[k], bends[k]))
        end = np.stack((turn, *end_rates(turn, rates[k + 1], bends[k + 1])))
        pieces.append(powers_between(h, start, end))
    return np.array(pieces)
