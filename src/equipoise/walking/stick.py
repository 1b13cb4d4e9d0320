"""A stick: how fast a robot is to walk, over time, and what a step may be of it."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from equipoise.errors import InputError
from equipoise.given import require_kind
from equipoise.spatial.numbers import real_number
from equipoise.walking.feet import LEFT
from equipoise.walking.footsteps import Stride, StrideLimits

AXES = ("forward", "left", "turn")
LEAST = 1e-3  # [m/s], [rad/s] below which a stick counts as let go


@dataclass(frozen=True)
class Stick:
    """How fast to walk: `forward` and to the `left` [m/s], `turn` [rad/s] to the left.

    Raises: `InputError`.
    """

    forward: float = 0.0
    left: float = 0.0
    turn: float = 0.0

    def __post_init__(self) -> None:
        for name in AXES:
            real_number(f"how fast to walk ({name})", getattr(self, name))

    @property
    def held(self) -> bool:
        """Whether it says to walk."""
        return max(abs(getattr(self, name)) for name in AXES) > LEAST

    def stride(self, foot: int, period: float) -> Stride:
        """Return how far a step of a foot goes on, where a step begins every `period` [s].

        The foot on the side it goes or turns to takes what is sideways and turned of two steps, and
        the other one follows: feet never cross.
        """
        side = 1.0 if foot == LEFT else -1.0
        left, turn = (
            2.0 * period * one if one * side > 0.0 else 0.0 for one in (self.left, self.turn)
        )
        return Stride(period * self.forward, left, turn)

    def first_foot(self, limits: StrideLimits) -> int:
        """Return the foot that begins: the one on the side it goes to, or the right one."""
        left, turn = self.left / limits.side, self.turn / limits.turn
        towards = left if abs(left) >= abs(turn) else turn
        return LEFT if towards > 0.0 else 1 - LEFT

    def towards(self, other: Stick, share: float) -> Stick:
        """Return the stick that is a `share` of the way nearer to another one."""
        return Stick(*(
            (1.0 - share) * getattr(self, name) + share * getattr(other, name) for name in AXES
        ))  # fmt: skip


@dataclass(frozen=True)
class Clip:
    """From time `t` [s] on a walk is slower than its stick says, or changes later; `words` why."""

    t: float
    words: str

    def __str__(self) -> str:
        return f"t = {self.t:.3f} s: {self.words}"


def clipped(stick: Stick, limits: StrideLimits, period: float) -> tuple[Stick, str]:
    """Return the stick that keeps steps within limits, and what was cut off, in words.

    `period` [s] is from step to step.
    """
    most = {
        "forward": limits.forward / period,
        "left": 0.5 * limits.side / period,
        "turn": 0.5 * limits.turn / period,
    }
    values, told = [], []
    for name in AXES:
        wanted = getattr(stick, name)
        given = math.copysign(min(abs(wanted), most[name]), wanted)
        values.append(given)
        if given != wanted:
            told.append(_cut(name, wanted > 0.0, abs(wanted) / most[name], limits))
    return Stick(*values), "; ".join(told)


def _cut(name: str, positive: bool, share: float, limits: StrideLimits) -> str:
    """Return what is said of a step that was to go a `share` > 1 of what it may."""
    side = "to the left" if positive else "to the right"
    if name == "turn":
        most, unit, what = limits.turn, "rad", f"{side} is what the feet have room for"
    elif name == "left":
        most, unit, what = limits.side, "m", f"{side} is what the legs reach"
    else:
        most, unit = limits.forward, "m"
        what = f"{'forwards' if positive else 'backwards'} is what the legs reach"
    return f"step clipped: {most:.3g} {unit} {what}, {share * most:.3g} {unit} is wanted"


class StickSchedule:
    """Sticks over time: each is held from its moment on; before the first one nothing is.

    Raises: `InputError` for moments that do not ascend.
    """

    def __init__(self, moments: Sequence[tuple[float, Stick]]) -> None:
        self._times = [real_number("when a stick is moved", t) for t, _ in moments]
        self._sticks = [Stick(), *(one for _, one in moments)]
        for stick in self._sticks:
            require_kind("a stick", stick, Stick)
        for one, other in pairwise(self._times):
            if not one < other:
                raise InputError(
                    "each moment of a stick comes after the one before",
                    given=[one, other],
                )

    @property
    def moments(self) -> tuple[float, ...]:
        """When it is moved [s]."""
        return tuple(self._times)

    def at(self, t: float) -> Stick:
        """Return the stick of time `t` [s]."""
        return self._sticks[bisect_right(self._times, t)]
