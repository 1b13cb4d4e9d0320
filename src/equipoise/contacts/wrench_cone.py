"""Would the reaction at a sole have been possible: unilateral, inside the cone, pressure inside.

The rigid contacts of the paper are bilateral with infinite friction; these margins tell how far
the reaction was from what a real floor can give.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from equipoise.compiled import entrance
from equipoise.robots import Sole
from equipoise.spatial import Array


@dataclass(frozen=True)
class ReactionMargins:
    """Distances to what a floor cannot give; the reaction is possible if all are >= 0.

    `normal` [N]: normal force. `friction` [N]: cone radius minus tangential force. `pressure` [m]:
    distance of the centre of pressure to the nearest edge of the sole (-inf without a normal
    force). `yaw` [N m]: distance of the yaw moment to what friction in the sole can hold.
    """

    normal: float
    friction: float
    pressure: float
    yaw: float

    LABELS = ("normal", "friction", "pressure", "yaw")
    UNITS = ("N", "N", "m", "N m")

    @property
    def possible(self) -> bool:
        """Return whether a floor could have given this reaction."""
        return min(self.normal, self.friction, self.pressure, self.yaw) >= 0.0

    def as_array(self) -> Array:
        """Return the four margins (4,) in the order of `LABELS`."""
        return np.array([self.normal, self.friction, self.pressure, self.yaw])


def reaction_margins(lam: Array, sole: Sole, friction: float) -> ReactionMargins:
    """Return the margins of a wrench `lam` (6,), world on robot, in the axes of the sole.

    The yaw bound is that of a rectangle pressed on a plane with a linearised friction cone (the
    wrench cone of Caron, Pham and Nakamura 2015), written at the centre of the rectangle.
    """
    return ReactionMargins(*margins_of(np.array(lam, dtype=float), outline(sole, friction)))


def outline(sole: Sole, friction: float) -> Array:
    """Return what `margins_of` needs of a sole (5,): half lengths, centre, friction."""
    half = (sole.x_max - sole.x_min) / 2.0, (sole.y_max - sole.y_min) / 2.0
    centre = (sole.x_max + sole.x_min) / 2.0, (sole.y_max + sole.y_min) / 2.0
    return np.array([*half, *centre, friction])


@entrance
def margins_of(lam: np.ndarray, outline: np.ndarray) -> tuple[float, float, float, float]:
    """Return normal, friction, pressure and yaw margin of a wrench [6]."""
    half_x, half_y, centre_x, centre_y, friction = outline
    fx, fy, fz, mx, my, mz = lam
    mx_c = mx - centre_y * fz
    my_c = my + centre_x * fz
    mz_c = mz - (centre_x * fy - centre_y * fx)
    pressure = min(half_x - abs(my_c) / fz, half_y - abs(mx_c) / fz) if fz > 0.0 else -np.inf
    reach = friction * (half_x + half_y) * fz
    yaw_max = reach - abs(half_y * fx + friction * mx_c) - abs(half_x * fy + friction * my_c)
    yaw_min = -reach + abs(half_y * fx - friction * mx_c) + abs(half_x * fy - friction * my_c)
    cone = friction * fz - np.sqrt(fx * fx + fy * fy)
    return fz, cone, pressure, min(yaw_max - mz_c, mz_c - yaw_min)
