"""What sensors make of a true state: noise, bias, filter, delay, silence; seeded."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import numpy as np
import pinocchio as pin

from equipoise.contacts import ContactStack
from equipoise.errors import InputError, NameNotFoundError
from equipoise.physics.engine import PhysicsState
from equipoise.robots import Robot
from equipoise.spatial import Array

JOINT_POSITION, JOINT_VELOCITY, BASE = "joint_position", "joint_velocity", "base"


@dataclass(frozen=True)
class SensorModel:
    """Errors of one kind of sensor, in its own unit.

    `noise` is the standard deviation of white noise a tick, `bias` the standard deviation of a
    constant drawn once per component; `filter_time` [s] the time constant of a first-order low
    pass behind both; `delay` [s] a dead time, rounded up to whole ticks.
    """

    noise: float = 0.0
    bias: float = 0.0
    filter_time: float = 0.0
    delay: float = 0.0

    def __post_init__(self) -> None:
        for name in ("noise", "bias", "filter_time", "delay"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value >= 0.0):
                raise InputError(f"sensor {name} must be finite and not negative", given=value)


@dataclass(frozen=True)
class Silence:
    """A sensor that says nothing new from `start` to `end` [s].

    `sensor` is joint_position, joint_velocity, base, the name of a joint (its position and
    velocity) or of a contact (its forces). `reading`: `frozen` repeats the last value, `nan`
    gives none.
    """

    sensor: str
    start: float
    end: float = np.inf
    reading: Literal["frozen", "nan"] = "nan"


@dataclass(frozen=True)
class SensorModels:
    """Errors of all sensors.

    Units: joint positions [rad], velocities [rad/s]; base position [m] and angle [rad], linear
    [m/s] and angular velocity [rad/s]; contact forces [N] and moments [N m].
    """

    joint_position: SensorModel = field(default_factory=SensorModel)
    joint_velocity: SensorModel = field(default_factory=SensorModel)
    base_position: SensorModel = field(default_factory=SensorModel)
    base_angle: SensorModel = field(default_factory=SensorModel)
    base_velocity: SensorModel = field(default_factory=SensorModel)
    base_rate: SensorModel = field(default_factory=SensorModel)
    force: SensorModel = field(default_factory=SensorModel)
    moment: SensorModel = field(default_factory=SensorModel)
    silences: tuple[Silence, ...] = ()


class Reading(NamedTuple):
    """What is measured: `q` (nq,), `v` (nv,), `lam` (r,); NaN where a sensor says nothing."""

    q: Array
    v: Array
    lam: Array


class SensorSuite:
    """Reads true states tick by tick; the same seed gives the same readings.

    Positions err along the tangent (nv,) of the configuration, so that the base quaternion stays
    one; base components come first, as in v.
    """

    def __init__(
        self, robot: Robot, contacts: ContactStack, models: SensorModels, dt: float, seed: int
    ) -> None:
        self.robot, self.models = robot, models
        self._random = np.random.default_rng(seed)
        m, na = models, robot.na
        half = robot.nv_base // 2  # a fixed base is not measured
        parts = [(m.base_position, half), (m.base_angle, half), (m.joint_position, na)]
        self._q = _Line(parts, dt, self._random)
        parts = [(m.base_velocity, half), (m.base_rate, half), (m.joint_velocity, na)]
        self._v = _Line(parts, dt, self._random)
        units = [unit for c in contacts.contacts for unit in c.units]
        parts = [(m.moment if unit == "N m" else m.force, 1) for unit in units]
        self._lam = _Line(parts, dt, self._random)
        self._silences = [(one, self._entries(one, contacts)) for one in models.silences]
        self._perfect = not (self._q.errs or self._v.errs or self._lam.errs or self._silences)
        self._last: Reading | None = None
        self._origin: Array | None = None

    def _entries(
        self, silence: Silence, contacts: ContactStack
    ) -> tuple[list[int], list[int], list[int]]:
        """Return the silent entries of q, v and lam."""
        robot, name = self.robot, silence.sensor
        nq, nv = robot.nq_base, robot.nv_base
        if name == BASE:
            return list(range(nq)), list(range(nv)), []
        if name == JOINT_POSITION:
            return list(range(nq, robot.nq)), [], []
        if name == JOINT_VELOCITY:
            return [], list(range(nv, robot.nv)), []
        if name in robot.joint_names:
            k = robot.joint_index(name)
            return [nq + k], [nv + k], []
        if name in contacts.rows:
            rows = contacts.rows[name]
            return [], [], list(range(rows.start, rows.stop))
        known = (BASE, JOINT_POSITION, JOINT_VELOCITY, *contacts.rows, *robot.joint_names)
        raise NameNotFoundError("sensor", name, known)

    def read(self, state: PhysicsState) -> Reading:
        """Return what the sensors show of `state`; call it once a tick, in order of time."""
        if self._perfect:
            return Reading(state.q, state.v, state.lam)
        if self._origin is None:
            self._origin = state.q.copy()
        model = self.robot.model
        shift = self._q.pass_on(pin.difference(model, self._origin, state.q))
        reading = Reading(
            pin.integrate(model, self._origin, shift) if self._q.errs else state.q.copy(),
            self._v.pass_on(state.v) if self._v.errs else state.v.copy(),
            self._lam.pass_on(state.lam) if self._lam.errs else state.lam.copy(),
        )
        self._silence(state.t, reading)
        self._last = reading
        return reading

    def _silence(self, t: float, reading: Reading) -> None:
        for one, setup in self._silences:
            if not one.start <= t < one.end:
                continue
            last = self._last
            for name, entries in zip(("q", "v", "lam"), setup, strict=True):
                if not entries:
                    continue
                frozen = one.reading == "frozen" and last is not None
                getattr(reading, name)[entries] = getattr(last, name)[entries] if frozen else np.nan


class _Line:
    """Noise, bias, filter and delay for a stack of components."""

    def __init__(
        self, parts: list[tuple[SensorModel, int]], dt: float, random: np.random.Generator
    ) -> None:
        sizes = [size for _, size in parts]

        def spread(name: str) -> Array:
            return np.repeat([getattr(m, name) for m, _ in parts], sizes).astype(float)

        self._noise = spread("noise")
        self._bias = spread("bias") * random.normal(size=sum(sizes))
        self._keep = np.exp(-dt / np.maximum(spread("filter_time"), 1e-12))
        self._late = np.ceil(spread("delay") / dt - 1e-9).astype(int)
        self.errs = any(m != SensorModel() for m, _ in parts)
        self._random = random
        self._filtered: Array | None = None
        self._past: deque[Array] = deque(maxlen=int(self._late.max(initial=0)) + 1)

    def pass_on(self, true: Array) -> Array:
        """Return what is read of `true`."""
        if not self.errs:
            return true
        raw = true + self._bias + self._noise * self._random.normal(size=len(true))
        if self._filtered is None:
            self._filtered = raw
        self._filtered = raw + self._keep * (self._filtered - raw)
        self._past.append(self._filtered)
        newest = len(self._past) - 1
        setup = np.maximum(newest - self._late, 0)
        return np.array(self._past)[setup, np.arange(len(true))]
