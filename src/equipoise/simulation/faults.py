"""What goes wrong between controller and robot: pushes, late values, late ticks, weak motors."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from equipoise.errors import InputError
from equipoise.kinematics import KinematicsEvaluator
from equipoise.robots import Robot
from equipoise.simulation.sensors import Reading
from equipoise.spatial import Array
from equipoise.spatial.numbers import not_negative, require_period

T = TypeVar("T")
ROUNDING = 1e-9  # [s]


@dataclass(frozen=True)
class ExternalForce:
    """A force (3,) [N], world axes, at the origin of `frame` for `duration` [s]."""

    frame: str | int
    force: tuple[float, float, float]
    start: float
    duration: float

    def acts(self, t: float) -> bool:
        """Return whether it acts at time `t` [s]."""
        return self.start <= t < self.start + self.duration


@dataclass(frozen=True)
class Faults:
    """Everything that goes wrong.

    `measurement_delay`, `command_delay` [s], rounded up to whole ticks. `missed_ticks` is the
    probability that a control tick comes one period late, the torque before being held.
    `torque_share` is the share of each torque limit that the motors still give. `vanishing` names
    fixed bodies of the world, each with the time [s] from which on it is gone.
    """

    pushes: tuple[ExternalForce, ...] = ()
    measurement_delay: float = 0.0
    command_delay: float = 0.0
    missed_ticks: float = 0.0
    torque_share: float = 1.0
    vanishing: tuple[tuple[str, float], ...] = ()

    def __post_init__(self) -> None:
        for name in ("measurement_delay", "command_delay"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value >= 0.0):
                raise InputError(f"{name} must be finite and not negative", given=value)
        if not 0.0 <= self.missed_ticks < 1.0:
            raise InputError("missed_ticks must be in [0, 1)", given=self.missed_ticks)
        if not 0.0 <= self.torque_share <= 1.0:
            raise InputError("torque_share must be in [0, 1]", given=self.torque_share)


class DelayLine(Generic[T]):
    """Gives back what was put in `delay` [s] ago, or the oldest if there is none so old."""

    def __init__(self, delay: float, dt: float) -> None:
        delay, dt = not_negative("delay", delay, "s"), require_period(dt)
        self.ticks = int(np.ceil(delay / dt - 1e-9))
        self._past: deque[T] = deque(maxlen=self.ticks + 1)

    def pass_on(self, value: T) -> T:
        """Put `value` in, return the late one."""
        self._past.append(value)
        return self._past[0]


class FaultInjector:
    """Stands between controller and engine; the same seed gives the same faults."""

    def __init__(self, robot: Robot, faults: Faults, dt: float, seed: int) -> None:
        self.robot, self.faults = robot, faults
        self._none = faults == Faults()
        self._random = np.random.default_rng(seed)
        self._kinematics = KinematicsEvaluator(robot)
        self._readings: DelayLine[Reading] = DelayLine(faults.measurement_delay, dt)
        self._commands: DelayLine[Array] = DelayLine(faults.command_delay, dt)
        self._missed_last = False
        self._there = list(faults.vanishing)

    def vanished(self, t: float) -> list[str]:
        """Return the bodies that are gone from time `t` [s] on, each once."""
        gone = [one for one in self._there if one[1] <= t + ROUNDING]
        if gone:
            self._there = [one for one in self._there if one not in gone]
        return [name for name, _ in gone]

    def late_reading(self, reading: Reading) -> Reading:
        """Return the reading that arrives now."""
        return self._readings.pass_on(reading)

    def tick_is_missed(self) -> bool:
        """Draw whether the controller misses this tick; it never misses two in a row."""
        if self.faults.missed_ticks == 0.0:
            return False
        missed = bool(self._random.random() < self.faults.missed_ticks) and not self._missed_last
        self._missed_last = missed
        return missed

    def torque(self, commanded: Array) -> Array:
        """Return the torque (na,) [N m] that the motors give now."""
        if self._none:
            return commanded
        tau = self._commands.pass_on(commanded)
        limit = self.faults.torque_share * self.robot.tau_max
        return np.minimum(np.maximum(tau, -limit), limit)

    def external(self, t: float, q: Array, v: Array) -> Array:
        """Return the generalised force (nv,) of the pushes at time `t` [s]."""
        total = np.zeros(self.robot.nv)
        if not self.faults.pushes:
            return total
        acting: Sequence[ExternalForce] = [push for push in self.faults.pushes if push.acts(t)]
        if acting:
            kin = self._kinematics.at(q, v)
            for push in acting:
                total += kin.jacobian(push.frame)[:3].T @ np.array(push.force)
        return total
