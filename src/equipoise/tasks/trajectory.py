"""Targets as trajectories: minimum jerk through timed waypoints in SE(3)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pinocchio as pin
from scipy.interpolate import BSpline, make_interp_spline

from equipoise.errors import InputError
from equipoise.spatial import Array, skew


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


@dataclass(frozen=True)
class FixedPose(PoseTrajectory):
    """A pose that does not move."""

    T_world_target: pin.SE3

    def at(self, t: float) -> PoseSample:
        """Return the same pose at any time."""
        return PoseSample(self.T_world_target, np.zeros(6))


@dataclass(frozen=True)
class Waypoint:
    """A pose to be reached at time `t` [s]; with `stop` the motion comes to rest there."""

    t: float
    T_world_target: pin.SE3
    stop: bool = False


class WaypointTrajectory(PoseTrajectory):
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
        self._R_start = waypoints[0].T_world_target.rotation
        coordinates = self._coordinates()
        self._pieces = [
            _Piece.through(np.array(times[a : b + 1]), coordinates[a : b + 1])
            for a, b in self._rests()
        ]
        self._ends = np.array([piece.t_end for piece in self._pieces])
        self._asked, self._answer = first_time, self._sample(first_time)

    def _coordinates(self) -> Array:
        rows = []
        previous = np.zeros(3)
        for w in self.waypoints:
            rotation = pin.log3(self._R_start.T @ w.T_world_target.rotation)
            rotation = _nearest_branch(rotation, previous)
            previous = rotation
            rows.append(np.concatenate((w.T_world_target.translation, rotation)))
        return np.array(rows)

    def _rests(self) -> list[tuple[int, int]]:
        last = len(self.waypoints) - 1
        rests = [0, *(i for i, w in enumerate(self.waypoints) if w.stop and 0 < i < last), last]
        return list(pairwise(rests)) if last > 0 else []

    def at(self, t: float) -> PoseSample:
        """Return the pose and its rate at time `t` [s].

        The last answer is kept: several tasks ask for the same object at the same time.
        """
        if self._asked != t:
            self._answer = self._sample(t)
            self._asked = t
        return self._answer

    def _sample(self, t: float) -> PoseSample:
        first, last = self.waypoints[0], self.waypoints[-1]
        if t <= first.t or not self._pieces:
            return PoseSample(first.T_world_target, np.zeros(6))
        if t >= last.t:
            return PoseSample(last.T_world_target, np.zeros(6))
        piece = self._pieces[int(np.searchsorted(self._ends, t))]
        x, rate = piece.position(t), piece.rate(t)
        R = self._R_start @ pin.exp3(x[3:])
        twist = np.concatenate((rate[:3], R @ (pin.Jexp3(x[3:]) @ rate[3:])))
        return PoseSample(pin.SE3(R, x[:3]), twist)


@dataclass(frozen=True)
class AttachedTrajectory(PoseTrajectory):
    """A frame rigidly attached to a moving body, at `T_body_frame`."""

    body: PoseTrajectory
    T_body_frame: pin.SE3

    def at(self, t: float) -> PoseSample:
        """Return the pose and rate of the attached frame at time `t` [s]."""
        sample = self.body.at(t)
        T_world_body = sample.T_world_target
        lever = T_world_body.rotation @ self.T_body_frame.translation
        twist = sample.twist_world.copy()
        twist[:3] -= skew(lever) @ twist[3:]
        return PoseSample(T_world_body * self.T_body_frame, twist)


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


@dataclass(frozen=True)
class _Piece:
    """One rest-to-rest spline."""

    t_end: float
    position: BSpline
    rate: BSpline

    @classmethod
    def through(cls, times: Array, points: Array) -> _Piece:
        rest = [(1, np.zeros(points.shape[1])), (2, np.zeros(points.shape[1]))]
        spline = make_interp_spline(times, points, k=5, bc_type=(rest, rest))
        return cls(float(times[-1]), spline, spline.derivative())


def _nearest_branch(rotation: Array, previous: Array) -> Array:
    """Return the rotation vector of the same rotation that lies nearest to `previous`."""
    angle = float(np.linalg.norm(rotation))
    if angle < 1e-12:
        return rotation
    axis = rotation / angle
    turns = np.round((axis @ previous - angle) / (2.0 * np.pi))
    return axis * (angle + 2.0 * np.pi * turns)
