"""Targets as trajectories: minimum jerk through timed waypoints in SE(3)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pinocchio as pin
from scipy.interpolate import BSpline, PPoly, make_interp_spline

from equipoise.compiled.compilation import entrance
from equipoise.compiled.scratch import scratch, scratch_matrix
from equipoise.errors import InputError
from equipoise.spatial import Array, pose_row
from equipoise.spatial.kernels import (
    compose,
    crossed,
    rotation_matrix,
    rotation_rate,
    turned,
)


@dataclass(frozen=True)
class PoseSample:
    """A pose and its rate: `twist_world` (6,) = velocity of the origin, angular velocity."""

    T_world_target: pin.SE3
    twist_world: Array


class PoseTrajectory(ABC):
    """A pose as a smooth function of time."""

    @abstractmethod
    def at(self, t: float) -> PoseSample:
        """Return the pose and its rate at time `t` [s]."""

    def row(self, t: float) -> Array:
        """Return the same as kernels read it (18,): a pose row and the twist.

        It may be overwritten when the next time is asked for.
        """
        sample = self.at(t)
        return np.concatenate((pose_row(sample.T_world_target), sample.twist_world))


class CompiledTrajectory(PoseTrajectory):
    """A trajectory that is evaluated by a kernel."""

    @abstractmethod
    def row(self, t: float) -> Array:
        """Return pose row and twist (18,) at time `t` [s]."""

    def at(self, t: float) -> PoseSample:
        """Return the pose and its rate at time `t` [s]."""
        row = self.row(t)
        T = pin.SE3(row[:9].reshape(3, 3).T.copy(), row[9:12].copy())
        return PoseSample(T, row[12:].copy())


@dataclass(frozen=True)
class FixedPose(CompiledTrajectory):
    """A pose that does not move."""

    T_world_target: pin.SE3

    def __post_init__(self) -> None:
        row = np.concatenate((pose_row(self.T_world_target), np.zeros(6)))
        object.__setattr__(self, "_row", row)

    def row(self, t: float) -> Array:
        """Return the same row at any time."""
        return self._row


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
    """

    def __init__(self, waypoints: Sequence[Waypoint]) -> None:
        if not waypoints:
            raise InputError("a trajectory needs at least one waypoint")
        times = [w.t for w in waypoints]
        if not np.isfinite(times).all() or any(np.diff(times) <= 0.0):
            raise InputError("waypoint times must increase", given=times)
        self.waypoints = tuple(waypoints)
        first_time = float(times[0])
        coordinates = self._coordinates()
        self._first_time = first_time
        self._last_time = float(times[-1])
        splines = [
            _spline(np.array(times[a : b + 1]), coordinates[a : b + 1]) for a, b in self._rests()
        ]
        self._starts, self._powers = _joined(splines, coordinates[0], first_time)
        self._start = pose_row(waypoints[0].T_world_target)
        self._end = pose_row(waypoints[-1].T_world_target)
        self._asked, self._row = np.nan, np.zeros(18)

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
        """Return pose row and twist (18,) at time `t` [s].

        The last answer is kept: several tasks ask for the same object at the same time.
        """
        if self._asked != t:
            self._asked = t
            if t <= self._first_time:
                self._rest(self._start)
            elif t >= self._last_time:
                self._rest(self._end)
            else:
                waypoint_row(self._starts, self._powers, self._start, t, self._row)
        return self._row

    def _rest(self, pose: Array) -> None:
        self._row[:12] = pose
        self._row[12:] = 0.0


@dataclass(frozen=True)
class AttachedTrajectory(CompiledTrajectory):
    """A frame rigidly attached to a moving body, at `T_body_frame`."""

    body: PoseTrajectory
    T_body_frame: pin.SE3

    def __post_init__(self) -> None:
        object.__setattr__(self, "attached", pose_row(self.T_body_frame))
        object.__setattr__(self, "_row", np.zeros(18))

    def row(self, t: float) -> Array:
        """Return pose row and twist (18,) of the attached frame at time `t` [s]."""
        attached_row(self.body.row(t), self.attached, self._row)
        return self._row


@dataclass(frozen=True)
class TravelTrajectory(PoseTrajectory):
    """A body that goes `distance` [m] along `direction` (3,) with minimum jerk, without turning."""

    body: PoseTrajectory
    direction: Array
    start: float
    end: float
    distance: float

    def travel(self, t: float) -> tuple[float, float, float]:
        """Return how far it has gone [m], its speed [m/s] and acceleration [m/s^2] at `t` [s]."""
        span = self.end - self.start
        x = min(max((t - self.start) / span, 0.0), 1.0)
        way = x**3 * (10.0 - 15.0 * x + 6.0 * x * x)
        rate = 30.0 * x * x * (1.0 - x) ** 2 / span
        bend = 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x) / span**2
        return self.distance * way, self.distance * rate, self.distance * bend

    def at(self, t: float) -> PoseSample:
        """Return the pose and its rate at time `t` [s]."""
        sample = self.body.at(t)
        way, speed, _ = self.travel(t)
        T = sample.T_world_target
        moved = pin.SE3(T.rotation, T.translation + way * self.direction)
        twist = sample.twist_world.copy()
        twist[:3] += speed * self.direction
        return PoseSample(moved, twist)


def _spline(times: Array, points: Array) -> PPoly:
    """Return the quintic through `points` (k, 6) at `times` [s], at rest at both ends."""
    rest = [(1, np.zeros(points.shape[1])), (2, np.zeros(points.shape[1]))]
    whole = make_interp_spline(times, points, k=5, bc_type=(rest, rest))
    each = [PPoly.from_spline(BSpline(whole.t, column, whole.k)) for column in whole.c.T]
    return PPoly(np.stack([one.c for one in each], axis=2), each[0].x)


def _joined(splines: Sequence[PPoly], first: Array, t: float) -> tuple[Array, Array]:
    """Return where pieces start (n,) [s] and their powers (n, 6, 6), highest first, by time."""
    starts, powers = [np.array([t])], [np.zeros((1, 6, 6))]
    powers[0][0, 5] = first
    for spline in splines:
        real = np.flatnonzero(np.diff(spline.x) > 0.0)  # the knots at the ends are repeated
        starts.append(spline.x[real])
        powers.append(np.ascontiguousarray(spline.c.transpose(1, 0, 2)[real]))
    return np.concatenate(starts), np.concatenate(powers)


@entrance
def waypoint_row(
    starts: np.ndarray, powers: np.ndarray, T_start: np.ndarray, t: float, row: np.ndarray
) -> None:
    """Write pose row and twist [18] of position and rotation vector that are piecewise powers."""
    k = len(starts) - 1
    while k > 0 and starts[k] > t:
        k -= 1
    since = t - starts[k]
    x, rate = scratch(6), scratch(6)
    x[:] = 0.0
    rate[:] = 0.0
    for power in range(powers.shape[1]):
        for i in range(6):
            rate[i] = rate[i] * since + x[i]
            x[i] = x[i] * since + powers[k, power, i]
    turn = scratch_matrix(3, 3)
    rotation_matrix(x[3], x[4], x[5], turn)
    for i in range(3):
        row[9 + i], row[12 + i] = x[i], rate[i]
        column = turned(T_start, turn[0, i], turn[1, i], turn[2, i])
        row[3 * i], row[3 * i + 1], row[3 * i + 2] = column
    wx, wy, wz = rotation_rate(x[3], x[4], x[5], rate[3], rate[4], rate[5])
    row[15], row[16], row[17] = turned(T_start, wx, wy, wz)


@entrance
def attached_row(body: np.ndarray, attached: np.ndarray, row: np.ndarray) -> None:
    """Write pose row and twist [18] of a frame at `attached` [12] on a moving body."""
    compose(body, attached, row)
    rx, ry, rz = row[9] - body[9], row[10] - body[10], row[11] - body[11]
    cx, cy, cz = crossed(body[15], body[16], body[17], rx, ry, rz)
    row[12], row[13], row[14] = body[12] + cx, body[13] + cy, body[14] + cz
    row[15], row[16], row[17] = body[15], body[16], body[17]


def _nearest_branch(rotation: Array, previous: Array) -> Array:
    """Return the rotation vector of the same rotation that lies nearest to `previous`."""
    angle = float(np.linalg.norm(rotation))
    if angle < 1e-12:
        return rotation
    axis = rotation / angle
    turns = np.round((axis @ previous - angle) / (2.0 * np.pi))
    return axis * (angle + 2.0 * np.pi * turns)
