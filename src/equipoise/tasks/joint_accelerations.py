"""Joint accelerations bounded so that every joint can stop in time: one row a joint."""

from __future__ import annotations

import math

import numpy as np

from equipoise.compiled import compiled, entrance
from equipoise.errors import InputError
from equipoise.hqp import Block, Hierarchy, RowDescription
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.spatial.numbers import real_vector, require_period
from equipoise.tasks.alone import alone_of
from equipoise.tasks.base import require_rate
from equipoise.tasks.joint_rows import JointBoundsTask
from equipoise.tasks.view import JOINT_ACCELERATIONS, TaskView, joint_positions, joint_speeds

_NEAR = 1e-9  # [rad/s] bounds nearer than this are one


@compiled
def approach(room: float, rate: float, a: float, dt: float) -> float:
    """Return the fastest approach [rad/s] of a limit from which a joint stops in time.

    Near the limit it is `rate * room`, as ever. Further off it is the largest speed that drops by
    exactly `a dt` a tick until that line is reached, where both have the same slope. Source: the
    braking parabola (Del Prete 2018, viable bounds), here in discrete time for `q + v dt`.
    """
    if room <= (a / rate) * (1.0 / rate - 0.5 * dt):
        return rate * room
    start = 0.5 * (a / rate) * (1.0 / rate - dt)
    return math.sqrt(2.0 * a * (room - start)) - 0.5 * a * dt


@entrance
def approach_speed(room: float, rate: float, a: float, dt: float) -> float:
    """Return the fastest approach of one limit."""
    return approach(room, rate, a, dt)


@compiled
def acceleration_rows(task: TaskView) -> None:
    """Write the bounds of each joint's velocity; see `JointAccelerationsTask.numbers`."""
    numbers, na = task.numbers, (task.numbers.shape[0] - 1) // 4
    q, v, dt = joint_positions(task.state, na), joint_speeds(task.state, na), numbers[4 * na]
    for i in range(na):
        angle, v_max, a = q[i], numbers[2 * na + i], numbers[3 * na + i]
        low = -approach(angle - numbers[i], task.rate, a, dt)
        high = approach(numbers[na + i] - angle, task.rate, a, dt)
        if low > high:  # beyond one limit, and no room to brake for the other
            low = high = low if high < 0.0 else high
        slowest, fastest = v[i] - a * dt, v[i] + a * dt
        low, high = min(max(low, -v_max), v_max), min(max(high, -v_max), v_max)
        task.lower[task.at + i] = min(max(low, slowest), fastest)
        task.upper[task.at + i] = min(max(high, slowest), fastest)


class JointAccelerationsTask(JointBoundsTask):
    """Bound how fast each joint's velocity changes, so that it can stop before its limits.

    `|v - v_before| <= acceleration * period`, and v within the speeds from which the joint still
    stops before its position limits (moved in by `margin` [rad]) and within `velocity_share` of
    its speed limit. Where these contradict, as after a jump of the state, the acceleration wins. So
    lower never exceeds upper. `acceleration` (na,) [rad/s^2] comes from `advise_accelerations`;
    `period` [s] is that of the generator; `rate` [1/s] is that of the last approach. It belongs
    below the contacts in a level of its own, or their drift is squeezed too.
    Source: Del Prete 2018 (viable bounds); Flacco, De Luca and Khatib 2012 (bounds as a box).
    Differs from the print: exact in discrete time, see `approach`.
    Raises: `InputError`, `ShapeError`, `NonFiniteError`.
    """

    row_unit = "rad/s"
    kind = JOINT_ACCELERATIONS
    constant_rows = True
    alone = staticmethod(alone_of("acceleration", acceleration_rows))

    def __init__(
        self,
        name: str,
        robot: Robot,
        acceleration: Array,
        period: float,
        *,
        margin: float = 0.01,
        velocity_share: float = 0.95,
        rate: float = 5.0,
    ) -> None:
        super().__init__(name, robot, margin, velocity_share)
        self.acceleration = real_vector(f"the bounds of task {name!r}", acceleration, robot.na)
        if not (self.acceleration > 0.0).all():
            worst = robot.joint_names[int(np.argmin(self.acceleration))]
            raise InputError(
                f"the acceleration bounds of task {name!r} must be positive [rad/s^2]",
                given={worst: float(self.acceleration.min())},
            )
        self.period, self.rate = require_period(period), require_rate(name, rate)

    @property
    def needs_before(self) -> bool:
        """Whether its rows depend on the velocity of the tick before: they do."""
        return True

    @property
    def numbers(self) -> Array:
        """Lower and upper positions, speeds and accelerations of all joints, and the period."""
        return np.concatenate(
            (self.q_low, self.q_high, self.v_share, self.acceleration, [self.period])
        )

    def describe(self, block: Block, hierarchy: Hierarchy) -> tuple[RowDescription, ...]:
        """Return what a person calls each row: the acceleration, or what is closer than that.

        Both bounds lie `2 a period` apart where the acceleration gives them both.
        """
        described = []
        ends = (hierarchy.upper[block.rows], hierarchy.lower[block.rows])
        widths = 2.0 * self.acceleration * self.period
        for joint, upper, lower, width, speed in zip(
            block.labels, *ends, widths, self.v_share, strict=True
        ):
            whole = upper - lower >= width - _NEAR
            above = self._limit("upper", joint, upper, speed, whole)
            below = self._limit("lower", joint, lower, speed, whole)
            described.append(RowDescription("rad/s", above, below, math.nan, math.nan))
        return tuple(described)

    @staticmethod
    def _limit(side: str, joint: str, bound: float, speed: float, whole: bool) -> str:
        if abs(bound) >= speed:
            return f"the speed limit of {joint}"
        if whole:
            return f"the acceleration limit of {joint}"
        return f"the room that {joint} needs to stop before its {side} limit"
