"""Forces of the contacts as arrows, measured and wanted, for every picture in three dimensions.

At a hand an arrow ends where the force acts. At a sole it stands on the floor beside the foot,
level with the centre of pressure, and points where the floor pushes: up.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from equipoise.analysis.rendering.sole_arrows import outer_sides, sole_arrow
from equipoise.contacts import (
    Contact,
    GraspContact,
    MovingSurfaceContact,
    PointContact,
    SoleContact,
    SurfaceContact,
)
from equipoise.kinematics import Kinematics
from equipoise.simulation.build.setup import Setup
from equipoise.spatial import Array

HAND_SCALE = 1e-2  # [m/N]
BESIDE = 0.025  # [m] between an arrow and its wanted one


@dataclass(frozen=True)
class Arrows:
    """Arrows (2, 3) [m] from tail to tip, world axes: the forces on the robot, and the wanted."""

    measured: list[Array]
    wanted: list[Array]


class ForceArrows:
    """Makes the arrows of the contacts of a setup."""

    def __init__(self, setup: Setup) -> None:
        self._contacts = setup.contacts.contacts
        self._sides = outer_sides(setup)

    def at(self, kin: Kinematics, values: Mapping[str, Array]) -> Arrows:
        """Return the arrows of logged `values` by channel, at the state they were logged at."""
        measured, wanted = [], []
        for contact in self._contacts:
            lam = values.get(f"lam/{contact.name}")
            if lam is None:
                continue
            measured += self._of(contact, kin, lam, 0.0)
            target = _wanted_rows(contact, values)
            if target is not None:
                wanted += self._of(contact, kin, target, BESIDE)
        return Arrows(measured, wanted)

    def _of(self, contact: Contact, kin: Kinematics, lam: Array, beside: float) -> list[Array]:
        if isinstance(contact, SoleContact):
            arrow = sole_arrow(contact, kin, lam, self._sides[contact.name], beside)
            return [] if arrow is None else [arrow]
        return hand_arrows(contact, kin, lam, beside)


def hand_arrows(contact: Contact, kin: Kinematics, lam: Array, beside: float = 0.0) -> list[Array]:
    """Return arrows (2, 3) [m] from tail to tip, world axes, for the rows `lam` at a hand.

    They are the forces on the robot, moved by `beside` [m] for the sake of another arrow.
    """
    if not np.isfinite(lam).all() or not lam.any():
        return []
    for kind, arrows in _KINDS.items():
        if isinstance(contact, kind):
            return arrows(contact, kin, lam, beside)
    return []


def ending(point: Array, arrow: Array) -> Array:
    """Return the arrow (2, 3) that ends at a point (3,)."""
    return np.array([point - arrow, point])


def _grasp(contact: GraspContact, kin: Kinematics, lam: Array, beside: float) -> list[Array]:
    T_a, T_b = kin.placement(contact.frame_a), kin.placement(contact.frame_b)
    force, shift = HAND_SCALE * (T_a.rotation @ lam[:3]), _up(beside)
    return [ending(T_b.translation + shift, force), ending(T_a.translation + shift, -force)]


def _surface(
    contact: SurfaceContact | MovingSurfaceContact, kin: Kinematics, lam: Array, beside: float
) -> list[Array]:
    point = contact.position(kin) + _up(beside)
    return [ending(point, HAND_SCALE * lam[0] * contact.normal(kin))]


def _point(contact: PointContact, kin: Kinematics, lam: Array, beside: float) -> list[Array]:
    return [ending(contact.p_world + _up(beside), HAND_SCALE * lam[:3])]


_KINDS: dict[type | tuple[type, ...], Callable[..., list[Array]]] = {
    GraspContact: _grasp,
    (SurfaceContact, MovingSurfaceContact): _surface,
    PointContact: _point,
}


def _up(height: float) -> Array:
    return np.array([0.0, 0.0, height])


def _wanted_rows(contact: Contact, values: Mapping[str, Array]) -> Array | None:
    """Return the rows of a contact with the wanted values, zero where none is wanted."""
    target = values.get(f"lam_ref/{contact.name}")
    if target is None:
        return None
    rows = np.zeros(contact.size)
    for label, value in zip(contact.regulated, target, strict=True):
        rows[contact.labels.index(label)] = value
    return rows
