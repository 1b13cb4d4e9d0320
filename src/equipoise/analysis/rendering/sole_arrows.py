"""The floor's force on a sole as an arrow, for every picture in three dimensions.

It stands on the floor beside the foot, where the leg does not hide it, level with the centre of
pressure, and points where the floor pushes: up.
"""

from __future__ import annotations

import numpy as np

from equipoise.contacts import SoleContact
from equipoise.kinematics import Kinematics
from equipoise.simulation.build.setup import Setup
from equipoise.spatial import Array

SOLE_SCALE = 1e-3  # [m/N]
OUTSIDE = 0.03  # [m] between a sole's edge and its arrow


def sole_arrow(
    contact: SoleContact, kin: Kinematics, lam: Array, side: float, beside: float = 0.0
) -> Array | None:
    """Return the arrow (2, 3) [m] from tail to tip in world axes; None without a load.

    It stands where the sole is at the state of `kin`: feet may walk. `lam` (6,) is the wrench in
    the sole's axes; the arrow stands on the foot's left (`side` 1) or right (-1), further out by
    `beside` [m] for the sake of another.
    """
    if not (np.isfinite(lam).all() and lam[2] > 0.0):
        return None
    T, sole = kin.placement(contact.sole.frame), contact.sole
    edge = sole.y_max if side > 0.0 else sole.y_min
    foot = T.act(np.array([pressure_in_sole(lam)[0], edge + side * (OUTSIDE + beside), 0.0]))
    return np.array([foot, foot + SOLE_SCALE * (T.rotation @ lam[:3])])


def sole_contacts(setup: Setup) -> list[SoleContact]:
    """Return the contacts of the soles."""
    return [contact for contact in setup.soles.contacts if isinstance(contact, SoleContact)]


def outer_sides(setup: Setup) -> dict[str, float]:
    """Return for each sole on which side of it the other soles are not: 1 left, -1 right."""
    anchors = {contact.name: contact.T_world_anchor for contact in sole_contacts(setup)}
    if not anchors:
        return {}
    middle = np.mean([T.translation for T in anchors.values()], axis=0)
    return {name: 1.0 if T.actInv(middle)[1] <= 0.0 else -1.0 for name, T in anchors.items()}


def pressure_in_sole(lam: Array) -> Array:
    """Return where the wrench `lam` (6,) of a loaded sole presses (3,) [m], in its axes."""
    return np.array([-lam[4] / lam[2], lam[3] / lam[2], 0.0])
