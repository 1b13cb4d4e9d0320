"""Where a foot of a session stands: a sole with its axes, or a point."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin

from equipoise.contacts import PointContact, SoleContact
from equipoise.spatial import Array

Foot = SoleContact | PointContact


def place_of(foot: Foot) -> pin.SE3:
    """Return where a foot stands."""
    if isinstance(foot, SoleContact):
        return foot.T_world_anchor
    return pin.SE3(np.eye(3), np.array(foot.p_world, dtype=float))


def centre_of(foot: Foot) -> Array:
    """Return the middle (3,) [m] of where a foot stands."""
    T = place_of(foot)
    if not isinstance(foot, SoleContact):
        return T.translation.copy()
    sole = foot.sole
    middle = np.array([sole.x_min + sole.x_max, sole.y_min + sole.y_max, 0.0]) / 2.0
    return np.asarray(T.act(middle))


def moved(foot: Foot, T_world_foot: pin.SE3) -> Foot:
    """Return a foot that stands elsewhere."""
    if isinstance(foot, SoleContact):
        return replace(foot, T_world_anchor=T_world_foot)
    return replace(foot, p_world=np.array(T_world_foot.translation))
