"""Balance feedback: the wanted centre of mass gives way to a push, and comes back to its plan."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from equipoise.contacts import SupportPolygon
from equipoise.given import require_kind
from equipoise.spatial import Array
from equipoise.spatial.numbers import not_negative, positive
from equipoise.walking.centre import CentreState

SETTLED = 1e-9  # [m] from its plan at which a reference is on it again


@dataclass(frozen=True)
class BalanceSettings:
    """How the reference answers where the robot is.

    `gain` [1/s]: rate at which an error of the divergent component dies out. `margin` [m]: how far
    inside the soles the zero-moment point is kept. `leash` [m]: how far the divergent component
    may be from its reference before the reference goes with it. `step` [m]: how far from its plan a
    foot may be put down to catch it; zero: never.
    Raises: `InputError`.
    """

    gain: float = 3.0
    margin: float = 0.01
    leash: float = 0.01
    step: float = 0.0

    def __post_init__(self) -> None:
        positive("the gain of the balance", self.gain, "1/s")
        not_negative("the margin of the balance", self.margin, "m")
        positive("the leash of the balance", self.leash, "m")
        not_negative("the step of the balance", self.step, "m")


class BalanceFeedback:
    """How far the wanted centre of mass is from its plan: `p` (2,) [m], `v` (2,) [m/s].

    That difference is a pendulum of its own, of rate `omega` [1/s]. It is dragged along where the
    robot's divergent component leaves its leash, and led back by a zero-moment point that stays in
    the soles. Its velocity is dragged, and its position follows: the law pulls the robot towards
    its reference, which would run ahead of the robot otherwise. A robot on its leash and a
    reference on its plan change nothing, to the last bit.

    Source: the divergent component (capture point) as what has to be led, Englsberger, Ott, Roa,
    Albu-Schaeffer and Hirzinger, "Bipedal walking control based on capture point dynamics", 2011.
    """

    def __init__(self, settings: BalanceSettings, omega: float, dt: float) -> None:
        require_kind("how the balance is kept", settings, BalanceSettings)
        self.settings = settings
        self.omega = positive("the rate of the pendulum", omega, "1/s")
        self.p, self.v, self.zmp = np.zeros(2), np.zeros(2), np.zeros(2)
        self.off = np.zeros(2)  # [m] the robot's divergent component from its plan
        self._grow = math.exp(omega * positive("the period of the balance", dt, "s"))
        # with the zero-moment point held over a tick the error shrinks by exp(-gain dt) exactly
        self.share = (self._grow - math.exp(-settings.gain * dt)) / (self._grow - 1.0)

    @property
    def acts(self) -> bool:
        """Whether the reference is off its plan."""
        return bool(self.p.any() or self.v.any())

    def after(self, T: float) -> Array:
        """Return how far off its plan (2,) [m] the divergent component is in T [s], as it goes."""
        dcm = self.p + self.v / self.omega
        grown: Array = self.zmp + (dcm - self.zmp) * math.exp(self.omega * T)
        return grown

    def hand_over(self, planned: CentreState) -> CentreState:
        """Return where the reference is, and begin again on a plan that goes on from there."""
        state = planned._replace(
            p=planned.p + self.p, v=planned.v + self.v,
            dcm=planned.dcm + self.p + self.v / self.omega,
        )  # fmt: skip
        self.p, self.v, self.zmp = np.zeros(2), np.zeros(2), np.zeros(2)
        return state

    def drag(self, planned: CentreState, p: Array, v: Array) -> None:
        """Let the reference go with a robot whose centre of mass is at `p` (2,) and moves with `v`.

        `planned` is the plan at that moment.
        """
        self.off = (p - planned.p) + (v - planned.v) / self.omega
        off = self.off - self.p - self.v / self.omega
        length = math.hypot(off[0], off[1])
        if length > self.settings.leash:
            self.v = self.v + self.omega * (1.0 - self.settings.leash / length) * off

    def advance(self, zmp: Array, polygon: SupportPolygon) -> None:
        """Go on by a tick, led by a zero-moment point that is in the polygon.

        `zmp` (2,) [m] is where the plan has it.
        """
        if not self.acts:
            self.zmp = np.zeros(2)
            return
        dcm = self.p + self.v / self.omega
        wanted = self.share * dcm
        self.zmp = room_towards(polygon, zmp, wanted, self.settings.margin) * wanted
        a = 0.5 * (dcm - self.zmp)
        b = self.p - self.zmp - a
        a, b = a * self._grow, b / self._grow
        self.p, self.v = self.zmp + a + b, self.omega * (a - b)
        if max(np.abs(self.p).max(), np.abs(self.v).max() / self.omega) < SETTLED:
            self.p, self.v = np.zeros(2), np.zeros(2)


def room_towards(polygon: SupportPolygon, start: Array, way: Array, margin: float) -> float:
    """Return the share of `way` (2,) [m] from `start` that stays `margin` inside, at most 1.

    A start that is nearer to an edge, or outside, may stay there, and go inwards only.
    """
    speed = polygon.normals @ way
    room = np.maximum(polygon.offsets - margin - polygon.normals @ start, 0.0)
    outwards = speed > room
    return float((room[outwards] / speed[outwards]).min()) if outwards.any() else 1.0
