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
from equipoise.trajectories.minimum_jerk import FASTEST
from equipoise.trajectories.quintic import powers_between
from equipoise.walking.foot_path import OFFSETS, POWERS, FootPath, constant, line, shifted
from equipoise.walking.pieces import STEP

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


class Swing(FootPath):
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
        super().__init__(T_from, *self._pieces())

    def _pieces(self) -> tuple[list[float], list[Array]]:
        """Return when the pieces begin, and their powers."""
        T, lift, land, shape = self.duration, self.lift, self.land, self.shape
        rise, touchdown = float(self._way[2]), shape.touchdown
        top = max(rise, 0.0) + shape.height
        turning = lift + RISE * T
        start, stop = lift + ACROSS[0] * T, lift + ACROSS[1] * T
        rest, summit, down = ([0.0] * 3, [top, 0.0, 0.0], [rise, -touchdown, 0.0])
        upwards = [
            (lift, _between(RISE * T, rest, summit)),
            (turning, _between(land - turning, summit, down)),
        ]
        turn = pin.log3(self.T_from.rotation.T @ self.T_to.rotation)
        goal = np.concatenate((self._way[:2], [0.0], turn))
        step = np.outer(STEP[::-1] / (stop - start) ** np.arange(POWERS - 1, -1.0, -1.0), goal)
        across = [(lift, constant(0.0 * goal)), (start, step), (stop, constant(goal))]
        starts = sorted([lift, turning, start, stop])
        powers = []
        for begin in starts:
            piece = _going_at(across, begin)
            piece[:, 2] = _going_at(upwards, begin)
            powers.append(piece)
        there, sinking = goal.copy(), np.zeros(OFFSETS)
        there[2], sinking[2] = rise, -touchdown
        if shape.search:
            starts.append(land)
            powers.append(line(there, sinking))
        there[2] -= shape.search
        return [*starts, land + shape.search / touchdown], [*powers, constant(there)]

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


def _between(duration: float, begin: list[float], end: list[float]) -> Array:
    """Return the powers (6,) of a quintic between two states: value and two derivatives."""
    powers = powers_between(duration, np.array(begin)[:, None], np.array(end)[:, None])
    one: Array = powers[:, 0]
    return one


def _going_at(pieces: list[tuple[float, Array]], t: float) -> Array:
    """Return the powers, from time `t` [s] on, of the piece that goes on then."""
    begin, powers = next(one for one in reversed(pieces) if one[0] <= t)
    return shifted(powers, t - begin)
