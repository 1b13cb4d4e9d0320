"""What a floor can give at one foot: rows on its wrench, with what happens if one is broken."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from equipoise.contacts import Contact, PointContact, SoleContact
from equipoise.errors import InputError
from equipoise.spatial import Array
from equipoise.spatial.numbers import not_negative, share

Foot = SoleContact | PointContact

_SIDES = 8


@dataclass(frozen=True)
class ReactionBounds:
    """How far from the edge a predicted reaction is kept.

    `normal_min` [N] on each sole; `friction_share` of the cone; `pressure_margin` [m] of the
    centre of pressure to the edges; `torque_share` of what the motors of the joints that carry
    have; `warn` [N]: how close to a bound a sole is reported.
    """

    normal_min: float = 10.0
    friction_share: float = 0.9
    pressure_margin: float = 0.005
    torque_share: float = 0.7
    warn: float = 10.0

    def __post_init__(self) -> None:
        for name in ("normal_min", "pressure_margin", "warn"):
            not_negative(name, getattr(self, name))
        share("friction_share", self.friction_share)
        share("torque_share", self.torque_share)


@dataclass(frozen=True)
class BoundRows:
    """`A lam >= b` (m,), in newtons, with what happens to the sole if a row is broken."""

    A: Array
    b: Array
    what: tuple[str, ...]


def require_feet(contacts: Sequence[Contact]) -> tuple[Foot, ...]:
    """Return the contacts if all are soles or points. Raises: `InputError`."""
    feet = tuple(contact for contact in contacts if isinstance(contact, SoleContact | PointContact))
    others = [c.name for c in contacts if not isinstance(c, SoleContact | PointContact)]
    if others:
        raise InputError(
            "only soles and feet that are points can share out the base wrench within bounds",
            given=others,
            remedy="Leave the bounds out, or let soles and points support the base only",
        )
    return feet


def bounds_of(foot: Foot, bounds: ReactionBounds) -> BoundRows:
    """Return the rows of one foot: of a sole on its wrench (6,), of a point on its force (3,)."""
    rows, offsets = [np.eye(foot.size)[2]], [bounds.normal_min]
    what = [f"{foot.name} lifts"]
    reach = bounds.friction_share * foot.friction * np.cos(np.pi / _SIDES)
    for angle in 2.0 * np.pi * np.arange(_SIDES) / _SIDES:
        row = np.zeros(foot.size)
        row[:3] = -np.cos(angle), -np.sin(angle), reach
        rows.append(row)
        offsets.append(0.0)
        what.append(f"{foot.name} slips")
    found = BoundRows(np.array(rows), np.array(offsets), tuple(what))
    return found if isinstance(foot, PointContact) else _with_moments(found, foot, bounds)


def _with_moments(found: BoundRows, sole: SoleContact, bounds: ReactionBounds) -> BoundRows:
    """Return the rows of a sole with those on its moments, in the axes of the sole."""
    s, friction = sole.sole, bounds.friction_share * sole.friction
    name = sole.name
    rows, offsets, what = [*found.A.tolist()], [*found.b.tolist()], [*found.what]

    def add(row: Iterable[float], sentence: str) -> None:
        rows.append(list(row))
        offsets.append(0.0)
        what.append(f"{name} {sentence}")

    m = bounds.pressure_margin
    half_x, half_y = 0.5 * (s.x_max - s.x_min), 0.5 * (s.y_max - s.y_min)
    x, y = 1.0 / half_x, 1.0 / half_y
    add((0, 0, (s.x_max - m) * x, 0, x, 0), "tips over its front edge")
    add((0, 0, -(s.x_min + m) * x, 0, -x, 0), "tips over its rear edge")
    add((0, 0, (s.y_max - m) * y, -y, 0, 0), "tips over its left edge")
    add((0, 0, -(s.y_min + m) * y, y, 0, 0), "tips over its right edge")
    for row in _yaw_rows(sole, friction):
        add(row, "turns")
    return BoundRows(np.array(rows, dtype=float), np.array(offsets), tuple(what))


def _yaw_rows(sole: SoleContact, friction: float) -> list[Array]:
    """Return the eight rows that bound the yaw moment (see `contacts.reaction_margins`)."""
    s = sole.sole
    half_x, half_y = 0.5 * (s.x_max - s.x_min), 0.5 * (s.y_max - s.y_min)
    centre_x, centre_y = 0.5 * (s.x_max + s.x_min), 0.5 * (s.y_max + s.y_min)
    fx, fy, fz, mx, my, mz = np.eye(6)
    mx_c, my_c = mx - centre_y * fz, my + centre_x * fz
    mz_c = mz - (centre_x * fy - centre_y * fx)
    reach = friction * (half_x + half_y)
    rows = []
    for turn in (1.0, -1.0):
        across, along = half_y * fx + turn * friction * mx_c, half_x * fy + turn * friction * my_c
        for a in (1.0, -1.0):
            for b in (1.0, -1.0):
                rows.append((reach * fz - a * across - b * along - turn * mz_c) / reach)
    return rows
