"""The targets of a tick: which there are, in which order, and the one place that calls kernels.

A new kind of trajectory is its file and a line in `evaluate_target`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from equipoise.compiled import compiled, inlined
from equipoise.compiled.workspace import Arrays, Block, Part, Shape, integers, matrix, vector
from equipoise.spatial import Array
from equipoise.trajectories.attached import attached_row
from equipoise.trajectories.base import (
    ATTACHED,
    FIXED,
    GIVEN,
    LIVE,
    ROW,
    TRAVEL,
    WAYPOINTS,
    CompiledTrajectory,
    PoseTrajectory,
)
from equipoise.trajectories.live import LiveTarget, live_row
from equipoise.trajectories.travel import travelling_row
from equipoise.trajectories.waypoints import waypoint_row

TARGETS = Arrays(("rows", "numbers", "kind", "body", "first"), frozenset({"kind", "body", "first"}))
ROWS, NUMBERS, KIND, BODY, FIRST = range(len(TARGETS.names))


class TargetList:
    """Trajectories, each once, those that others ride on before them."""

    def __init__(self) -> None:
        self.trajectories: list[PoseTrajectory] = []
        self._bodies: list[int] = []
        # number and trajectory of those that are asked from Python every tick
        self.given: list[tuple[int, PoseTrajectory]] = []
        self.live: list[LiveTarget] = []  # those that may be set between two ticks

    def number_of(self, trajectory: PoseTrajectory) -> int:
        """Return the number of a trajectory, which is added if it is new."""
        for number, known in enumerate(self.trajectories):
            if known is trajectory:
                return number
        body = trajectory.rides_on if isinstance(trajectory, CompiledTrajectory) else None
        number = -1 if body is None else self.number_of(body)
        self.trajectories.append(trajectory)
        self._bodies.append(number)
        if trajectory.kind == GIVEN:
            self.given.append((len(self.trajectories) - 1, trajectory))
        if isinstance(trajectory, LiveTarget):
            self.live.append(trajectory)
        return len(self.trajectories) - 1

    def lead(self, part: Part) -> None:
        """Let live targets keep their numbers in a part: its ticks are those that take them."""
        for k, one in enumerate(self.trajectories):
            if isinstance(one, LiveTarget):
                one.work_in(part.numbers[part.first[k] : part.first[k + 1]])

    def _numbers(self) -> list[Array]:
        return [
            one.numbers if isinstance(one, CompiledTrajectory) else np.zeros(0)
            for one in self.trajectories
        ]

    def shapes(self) -> list[tuple[str, Shape, bool]]:
        """Return the arrays: `rows` [k, 18] and what the kernels need."""
        count = max(len(self.trajectories), 1)
        pool = sum(len(numbers) for numbers in self._numbers())
        return TARGETS.shapes(
            rows=(count, ROW), numbers=max(pool, 1), kind=count, body=count, first=count + 1
        )

    def fill(self, part: Part) -> None:
        """Write the constants, and the rows of what does not move."""
        start = 0
        for k, (one, numbers) in enumerate(zip(self.trajectories, self._numbers(), strict=True)):
            part.kind[k], part.body[k], part.first[k] = one.kind, self._bodies[k], start
            part.numbers[start : start + len(numbers)] = numbers
            start += len(numbers)
            part.first[k + 1] = start
            if one.kind == FIXED:
                part.rows[k] = numbers


def write_given(part: Part, given: Sequence[tuple[int, PoseTrajectory]], t: float) -> None:
    """Ask the trajectories in plain Python for their rows at time `t` [s]."""
    for k, trajectory in given:
        part.rows[k] = trajectory.row(t)


@compiled
def evaluate_targets(targets: Block, t: float) -> None:
    """Write the rows of all targets that move, at time t."""
    for k in range(integers(targets, KIND).shape[0]):
        evaluate_target(targets, k, t)


@inlined
def live_numbers(targets: Block, k: int) -> np.ndarray:
    """Return the numbers of target k, if it is set while it runs, and nothing else."""
    first = integers(targets, FIRST)
    last = first[k + 1] if integers(targets, KIND)[k] == LIVE else first[k]
    return vector(targets, NUMBERS)[first[k] : last]


@compiled
def slow_targets(targets: Block, rate: float) -> None:
    """Slow the twists of all targets, whose time goes at a rate; where they are stays."""
    rows = matrix(targets, ROWS)
    for k in range(rows.shape[0]):
        for i in range(12, ROW):
            rows[k, i] *= rate


@compiled
def evaluate_target(targets: Block, k: int, t: float) -> None:
    """Write row k at time t."""
    rows, kind, first = matrix(targets, ROWS), integers(targets, KIND)[k], integers(targets, FIRST)
    numbers = vector(targets, NUMBERS)[first[k] : first[k + 1]]
    body = rows[max(integers(targets, BODY)[k], 0)]
    if kind == WAYPOINTS:
        waypoint_row(numbers, t, rows[k])
    elif kind == ATTACHED:
        attached_row(body, numbers, rows[k])
    elif kind == TRAVEL:
        travelling_row(body, numbers, t, rows[k])
    elif kind == LIVE:
        live_row(numbers, t, rows[k])
