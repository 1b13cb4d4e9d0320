"""A body that goes along a line with minimum jerk."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from equipoise.compiled import compiled, entrance
from equipoise.errors import InputError
from equipoise.spatial import Array
from equipoise.spatial.numbers import real_number
from equipoise.spatial.poses import unit_vector
from equipoise.trajectories.base import (
    NEARLY,
    ROW,
    SHORTEST,
    TRAVEL,
    CompiledTrajectory,
    PoseTrajectory,
    instant,
    require_trajectory,
)
from equipoise.trajectories.minimum_jerk import share_of, step, step_bend, step_rate


@dataclass(frozen=True)
class Travel:
    """From rest at `start` to rest at `end` [s] over `distance` [m], with minimum jerk.

    Raises: `InputError` if the end is not after the start.
    """

    start: float
    end: float
    distance: float

    def __post_init__(self) -> None:
        start, end, distance = (
            real_number(f"the {name} of a travel", getattr(self, name), finite=False)
            for name in ("start", "end", "distance")
        )
        if not (np.isfinite([start, end, distance]).all() and end - start >= NEARLY * SHORTEST):
            raise InputError(
                "a travel must end after it starts, over a finite distance",
                given=(self.start, self.end, self.distance),
                remedy="Give start and end [s] and the distance [m]",
            )

    @property
    def numbers(self) -> Array:
        """Start, end and distance (3,)."""
        return np.array([self.start, self.end, self.distance], dtype=float)

    def __call__(self, t: float) -> tuple[float, float, float]:
        """Return how far it has gone [m], its speed [m/s] and acceleration [m/s^2] at `t` [s]."""
        gone = np.empty(3)
        travel_alone(self.numbers, instant(t), gone)
        return float(gone[0]), float(gone[1]), float(gone[2])


@dataclass(frozen=True, init=False)
class TravelTrajectory(CompiledTrajectory):
    """A `body` that also travels along `direction` (3,), a unit vector, without turning.

    `travel` says from when to when [s] and how far [m]: a `Travel`, or its three numbers.
    Raises: `InputError` for what is none of these.
    """

    body: PoseTrajectory
    direction: Array
    travel: Travel
    kind = TRAVEL

    def __init__(
        self, body: PoseTrajectory, direction: Array, travel: Travel | float, *more: float
    ) -> None:
        require_trajectory("the body of a TravelTrajectory", body)
        if not isinstance(travel, Travel) and len(more) == 2:
            travel, more = Travel(travel, *more), ()
        if more or not isinstance(travel, Travel):
            raise InputError(
                "the travel of a TravelTrajectory must be a Travel",
                given=(travel, *more),
                remedy="Give TravelTrajectory(body, direction, Travel(start, end, distance))",
            )
        set_once = object.__setattr__  # a frozen dataclass
        set_once(self, "body", body)
        set_once(self, "direction", unit_vector("the direction of a TravelTrajectory", direction))
        set_once(self, "travel", travel)

    @cached_property
    def numbers(self) -> Array:
        """The travel's numbers and the direction (6,)."""
        return np.concatenate((self.travel.numbers, self.direction))

    @property
    def rides_on(self) -> PoseTrajectory:
        """The body."""
        return self.body

    def row(self, t: float) -> Array:
        """Return pose row and twist (18,) at time `t` [s]."""
        row = np.empty(ROW)
        travelling_alone(self.body.row(t), self.numbers, instant(t), row)
        return row


@compiled
def travelled(numbers: np.ndarray, t: float) -> tuple[float, float, float]:
    """Return way, speed and acceleration of a travel with these numbers (start, end, distance)."""
    start, end, distance = numbers[0], numbers[1], numbers[2]
    x, span = share_of(t, start, end), end - start
    return (
        distance * step(x),
        distance * step_rate(x) / span,
        distance * step_bend(x) / (span * span),
    )


@compiled
def travelling_row(body: np.ndarray, numbers: np.ndarray, t: float, row: np.ndarray) -> None:
    """Write pose row and twist [18] of a body that also travels."""
    way, speed, _ = travelled(numbers, t)
    for i in range(18):
        row[i] = body[i]
    for i in range(3):
        row[9 + i] += way * numbers[3 + i]
        row[12 + i] += speed * numbers[3 + i]


@entrance
def travel_alone(numbers: np.ndarray, t: float, gone: np.ndarray) -> None:
    """Write way, speed and acceleration of a travel."""
    gone[0], gone[1], gone[2] = travelled(numbers, t)


@entrance
def travelling_alone(body: np.ndarray, numbers: np.ndarray, t: float, row: np.ndarray) -> None:
    """Write the row of one travelling body."""
    travelling_row(body, numbers, t, row)
