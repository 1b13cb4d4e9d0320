"""A foot through the air: up, across, down softly, and on down until it finds the ground."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from equipoise.errors import InputError
from equipoise.given import require_kind
from equipoise.spatial import Array
from equipoise.spatial.numbers import not_negative, positive, real_number
from equipoise.spatial.poses import rigid
from equipoise.trajectories.minimum_jerk import FASTEST, share_of, step, step_bend, step_rate
from equipoise.trajectories.quintic import powers_between

RISE = 0.45  # share of the swing in which the foot goes up
LONGEST = 600.0  # [s] of a foot in the air
ACROSS = (0.02, 0.96)  # shares of the swing between which it goes across and turns


@dataclass(frozen=True)
class SwingShape:
    """How a foot swings: `height` [m] over the higher end, and `touchdown` [m/s] downwards.

    It meets the ground at that speed, and goes on at it for `search` [m] where there is none.
    Raises: `InputError`.
    """

    height: float = 0.05
    touchdown: float = 0.03
    search: float = 0.04

    def __post_init__(self) -> None:
        positive("the height of a swing", self.height, "m")
        positive("the speed of a touchdown", self.touchdown, "m/s")
        not_negative("the way a foot searches", self.search, "m")


@dataclass(frozen=True)
class FootSample:
    """A foot's pose with twist and acceleration (6,) in world axes: linear, then angular."""

    T_world_sole: pin.SE3
    twist: Array
    acceleration: Array


class Swing:
    """The way of a foot from `T_from` (lifted at `lift` [s]) to `T_to` (down at `land` [s]).

    Upwards it goes from rest to the top and down to a touchdown at a speed; across and in its turn
    it is a minimum-jerk step in the middle of that time. All of it is continuous to the second
    derivative. Behind `land` it goes straight down at the speed of touchdown.
    Raises: `InputError`.
    """

    def __init__(
        self, T_from: pin.SE3, T_to: pin.SE3, lift: float, land: float, shape: SwingShape
    ) -> None:
        require_kind("the shape of a swing", shape, SwingShape)
        rigid("where a swing begins", T_from)
        rigid("where a swing ends", T_to)
        lift, land = real_number("when a swing begins", lift), real_number("when it ends", land)
        if not 0.0 < land - lift <= LONGEST:
            raise InputError(
                f"a swing ends after it begins, and within {LONGEST:g} s", given=(lift, land)
            )
        self.T_from, self.T_to, self.lift, self.land, self.shape = T_from, T_to, lift, land, shape
        self._way = T_to.translation - T_from.translation
        self._axis = pin.log3(T_from.rotation.T @ T_to.rotation)
        # plain numbers, which are read every tick
        self._begin, self._across = T_from.translation[:2].tolist(), self._way[:2].tolist()
        self._turn: list[float] = (T_from.rotation @ self._axis).tolist()
        self._turns = bool(np.any(self._axis))
        T = land - lift
        z0, z1 = float(T_from.translation[2]), float(T_to.translation[2])
        top = max(z0, z1) + shape.height
        self._turning = lift + RISE * T
        rest, summit = [[z0], [0.0], [0.0]], [[top], [0.0], [0.0]]
        down = [[z1], [-shape.touchdown], [0.0]]
        self._up = powers_between(RISE * T, np.array(rest), np.array(summit))[:, 0].tolist()
        self._down = powers_between((1.0 - RISE) * T, np.array(summit), np.array(down))[
            :, 0
        ].tolist()

    rests_from = math.inf  # [s] from when on it stands still

    @property
    def fastest(self) -> float:
        """The greatest speed [m/s] across."""
        across = float(np.linalg.norm(self._way[:2]))
        return FASTEST * across / ((ACROSS[1] - ACROSS[0]) * (self.land - self.lift))

    @property
    def sharpest(self) -> float:
        """The greatest acceleration [m/s^2] across."""
        across = float(np.linalg.norm(self._way[:2]))
        return 10.0 / math.sqrt(3.0) * across / ((ACROSS[1] - ACROSS[0]) * self.duration) ** 2

    @property
    def duration(self) -> float:
        """How long [s] it is in the air, as planned."""
        return self.land - self.lift

    def at(self, t: float) -> FootSample:
        """Return the foot at time `t` [s]."""
        T, (begin, end) = self.duration, ACROSS
        start, stop = self.lift + begin * T, self.lift + end * T
        x, span = share_of(t, start, stop), stop - start
        s, rate, bend = step(x), step_rate(x) / span, step_bend(x) / span**2
        z, vz, az = self._upwards(t)
        R = self.T_from.rotation
        if self._turns:
            R = R @ pin.exp3(s * self._axis)
        (x0, y0), (dx, dy), (tx, ty, tz) = self._begin, self._across, self._turn
        return FootSample(
            pin.SE3(R, np.array([x0 + s * dx, y0 + s * dy, z])),
            np.array([rate * dx, rate * dy, vz, rate * tx, rate * ty, rate * tz]),
            np.array([bend * dx, bend * dy, az, bend * tx, bend * ty, bend * tz]),
        )

    def _upwards(self, t: float) -> tuple[float, float, float]:
        """Return height [m], its rate and its second derivative."""
        if t >= self.land:
            gone = min(self.shape.touchdown * (t - self.land), self.shape.search)
            sinks = gone < self.shape.search or not self.shape.search
            z = float(self.T_to.translation[2]) - gone
            return z, -self.shape.touchdown if sinks else 0.0, 0.0
        if t <= self.lift:
            return float(self.T_from.translation[2]), 0.0, 0.0
        up = t < self._turning
        powers, since = (self._up, self.lift) if up else (self._down, self._turning)
        return with_derivatives(powers, t - since)


class Standing:
    """A foot that stands."""

    rests_from = -math.inf

    def __init__(self, T_world_sole: pin.SE3) -> None:
        self.T_to = T_world_sole

    def at(self, t: float) -> FootSample:
        """Return the foot, at rest."""
        return FootSample(self.T_to, np.zeros(6), np.zeros(6))


def with_derivatives(powers: Array, s: float) -> tuple:  # type: ignore[type-arg]
    """Return a polynomial, highest power first, and its two derivatives."""
    x, v, a = 0.0 * powers[0], 0.0 * powers[0], 0.0 * powers[0]
    for power in powers:
        a, v, x = a * s + 2.0 * v, v * s + x, x * s + power
    return x, v, a
