"""Joint accelerations bounded so that every joint can stop in time: one row a joint."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from equipoise.compiled import compiled, entrance
from equipoise.compiled.workspace import integers, vector
from equipoise.errors import InputError
from equipoise.hqp import Block, Hierarchy, RowDescription
from equipoise.kinematics import Kinematics
from equipoise.kinematics.kernels import VELOCITY, Q
from equipoise.kinematics.tree import FIRST_Q, KIND
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.spatial.numbers import not_negative, real_vector, require_period, share
from equipoise.tasks.alone import alone_of
from equipoise.tasks.base import KernelTask, require_rate
from equipoise.tasks.joint_rows import write_joint_rows
from equipoise.tasks.view import JOINT_ACCELERATIONS, TaskView, first_actuated

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
    q, v, numbers = vector(task.state, Q), vector(task.state, VELOCITY), task.numbers
    first_q, first = integers(task.tree, FIRST_Q), first_actuated(task.tree)
    na = (numbers.shape[0] - 1) // 4
    dt, base = numbers[4 * na], v.shape[0] - na
    for j in range(first, integers(task.tree, KIND).shape[0]):
        i = j - first
        angle, v_max, a = q[first_q[j]], numbers[2 * na + i], numbers[3 * na + i]
        low = -approach(angle - numbers[i], task.rate, a, dt)
        high = approach(numbers[na + i] - angle, task.rate, a, dt)
        if low > high:  # beyond one limit, and no room to brake for the other
            low = high = low if high < 0.0 else high
        slowest, fastest = v[base + i] - a * dt, v[base + i] + a * dt
        low, high = min(max(low, -v_max), v_max), min(max(high, -v_max), v_max)
        task.lower[task.at + i] = min(max(low, slowest), fastest)
        task.upper[task.at + i] = min(max(high, slowest), fastest)


class JointAccelerationsTask(KernelTask):
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
        super().__init__(name)
        self._labels = robot.joint_names
        self.acceleration = real_vector(f"the bounds of task {name!r}", acceleration, robot.na)
        if not (self.acceleration > 0.0).all():
            worst = robot.joint_names[int(np.argmin(self.acceleration))]
            raise InputError(
                f"the acceleration bounds of task {name!r} must be positive [rad/s^2]",
                given={worst: float(self.acceleration.min())},
            )
        margin = not_negative(f"the margin of task {name!r}", margin, "rad")
        velocity_share = share(f"the velocity share of task {name!r}", velocity_share)
        self.period, self.rate = require_period(period), require_rate(name, rate)
        inset = np.minimum(margin, 0.25 * (robot.q_max - robot.q_min))
        self.q_low, self.q_high = robot.q_min + inset, robot.q_max - inset
        self.v_share = velocity_share * robot.v_max

    @property
    def labels(self) -> tuple[str, ...]:
        """The joint names."""
        return self._labels

    @property
    def units(self) -> tuple[str, ...]:
        """Radians (metres for a prismatic joint)."""
        return ("rad",) * len(self._labels)

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

    def write_constants(self, A: Array, robot: Any) -> None:
        """Write the velocities of the joints."""
        write_joint_rows(A, robot)

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return how far [rad] each joint is beyond its limits moved in by the margin."""
        q = kin.q[-len(self.q_low) :]
        return np.maximum(0.0, np.maximum(self.q_low - q, q - self.q_high))

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
