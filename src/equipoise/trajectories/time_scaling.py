"""Trajectories slowed where they are faster than is allowed: leg by leg, the way itself stays."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from itertools import pairwise

import numpy as np

from equipoise.errors import InputError
from equipoise.spatial import Array
from equipoise.spatial.numbers import positive
from equipoise.trajectories.waypoints import Waypoint, WaypointTrajectory

_SAMPLES = 400  # of a leg
_ROUNDS = 12
_CLOSE = 1e-3  # share by which a bound may be missed before all legs are scaled alike


@dataclass(frozen=True)
class MotionLimits:
    """How fast a frame may go: bounds on its trajectory, infinite where nothing is bounded.

    `speed` [m/s], `acceleration` [m/s^2] of its origin; `turn` [rad/s], `turn_acceleration`
    [rad/s^2].
    Raises: `InputError` for what is not positive.
    """

    speed: float = math.inf
    acceleration: float = math.inf
    turn: float = math.inf
    turn_acceleration: float = math.inf

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if value != math.inf:
                positive(field.name.replace("_", " "), value)

    @property
    def bounded(self) -> bool:
        """Whether anything is bounded."""
        return self != MotionLimits()


@dataclass(frozen=True)
class SlowedLeg:
    """Leg `number` (from 1) of a way takes `taken` [s] instead of `given` [s]."""

    number: int
    given: float
    taken: float

    def sentence(self, name: str) -> str:
        """Return it in words, for the frame or object of a name."""
        return f"leg {self.number} of {name} takes {self.taken:.3g} s instead of {self.given:.3g} s"


def slow_down(
    waypoints: Sequence[Waypoint], limits: MotionLimits
) -> tuple[tuple[Waypoint, ...], tuple[SlowedLeg, ...]]:
    """Return the waypoints with times at which the trajectory keeps the limits, and what changed.

    Legs that are too fast are stretched, and what follows comes later; a leg that need not be
    slower keeps its duration. Stretching all legs alike by c divides speeds by c and accelerations
    by c^2, so that there always is an answer.
    Source: Hollerbach 1984 (dynamic scaling of trajectories), by legs.
    Raises: `InputError` for waypoints that make no trajectory.
    """
    kept = tuple(waypoints)
    if not limits.bounded or len(kept) < 2:
        WaypointTrajectory(kept)
        return kept, ()
    given = np.diff([w.t for w in kept])
    if not (np.isfinite(given).all() and (given > 0.0).all()):
        raise InputError("waypoint times must increase", given=[w.t for w in kept])
    taken = _slower(kept, limits)
    slowed = tuple(
        SlowedLeg(k + 1, float(before), float(after))
        for k, (before, after) in enumerate(zip(given, taken, strict=True))
        if after > before * (1.0 + 2.0 * _CLOSE)
    )
    return (_timed(kept, taken), slowed) if slowed else (kept, ())


def _slower(way: Sequence[Waypoint], limits: MotionLimits) -> Array:
    """Return the durations (legs,): leg by leg, or all legs between two rests alike if shorter."""
    given, over = np.diff([w.t for w in way]), excess(way, limits)
    rests = [0, *(k for k in range(1, len(way) - 1) if way[k].stop), len(way) - 1]
    sections = [slice(a, b) for a, b in pairwise(rests)]
    alike, taken = given.copy(), given.copy()
    for legs in sections:
        alike[legs] *= max(over[legs].max(), 1.0)
    for _ in range(_ROUNDS):
        taken *= np.where(over > 1.0 + _CLOSE, over, 1.0)
        _take_shorter(taken, alike, sections)
        over = excess(_timed(way, taken), limits)
    for legs in sections:
        taken[legs] *= max(over[legs].max(), 1.0)
    _take_shorter(taken, alike, sections)
    return taken


def _take_shorter(taken: Array, alike: Array, sections: Sequence[slice]) -> None:
    """Write durations that are alike where they are shorter in sum."""
    for legs in sections:
        if taken[legs].sum() > alike[legs].sum():
            taken[legs] = alike[legs]


def excess(waypoints: Sequence[Waypoint], limits: MotionLimits) -> Array:
    """Return by what factor each leg would have to be slower to keep the limits (legs,)."""
    way, times = WaypointTrajectory(waypoints), [w.t for w in waypoints]
    factors = np.zeros(len(times) - 1)
    for k in range(len(factors)):
        at = np.linspace(times[k], times[k + 1], _SAMPLES + 1)
        twists = np.array([way.row(t)[12:] for t in at])
        rates = np.diff(twists, axis=0) / (at[1] - at[0])
        factors[k] = max(
            _longest(twists[:, :3]) / limits.speed,
            _longest(twists[:, 3:]) / limits.turn,
            math.sqrt(_longest(rates[:, :3]) / limits.acceleration),
            math.sqrt(_longest(rates[:, 3:]) / limits.turn_acceleration),
        )
    return factors


def _timed(waypoints: Sequence[Waypoint], durations: Array) -> tuple[Waypoint, ...]:
    times = waypoints[0].t + np.concatenate(([0.0], np.cumsum(durations)))
    return tuple(replace(w, t=float(t)) for w, t in zip(waypoints, times, strict=True))


def _longest(vectors: Array) -> float:
    return float(np.linalg.norm(vectors, axis=1).max())
