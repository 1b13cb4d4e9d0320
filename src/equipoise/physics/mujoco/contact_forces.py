"""From wrenches at the pads to the multipliers of the contacts' own rows."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from equipoise.contacts import Contact, ContactStack, GraspContact, SoleContact
from equipoise.kinematics import Kinematics
from equipoise.spatial import Array

Wrench = tuple[Array, Array]  # force [N] and moment [N m] at a frame's origin, world axes


def multipliers(contacts: ContactStack, kin: Kinematics, wrenches: Mapping[int, Wrench]) -> Array:
    """Return `lam` (r,) of the stack, world on robot, from the wrench at each touching frame.

    `wrenches[frame_id]` is what the world does to the pad of a frame.
    """
    lam = np.zeros(contacts.size)
    for contact in contacts.contacts:
        lam[contacts.rows[contact.name]] = _multiplier(contact, kin, wrenches)
    return lam


def _multiplier(contact: Contact, kin: Kinematics, wrenches: Mapping[int, Wrench]) -> Array:
    if isinstance(contact, SoleContact):
        force, moment = wrenches[contact.frame_id]
        R = contact.T_world_anchor.rotation
        return np.concatenate((R.T @ force, R.T @ moment))
    if isinstance(contact, GraspContact):
        return _internal_wrench(contact, kin, wrenches)
    force, _ = wrenches[contact.frame_id]
    return np.array([contact.normal(kin) @ force])


def _internal_wrench(
    contact: GraspContact, kin: Kinematics, wrenches: Mapping[int, Wrench]
) -> Array:
    """Return half the difference of what the object does to b and to a: its weight drops out.

    Both are taken at the origin of b and in the axes of a.
    """
    T_a, T_b = kin.placement(contact.frame_a), kin.placement(contact.frame_b)
    force_a, moment_a = wrenches[contact.frame_a]
    force_b, moment_b = wrenches[contact.frame_b]
    lever = T_a.translation - T_b.translation
    moment_a_at_b = moment_a + np.cross(lever, force_a)
    R = T_a.rotation.T
    force = 0.5 * R @ (force_b - force_a)
    moment = 0.5 * R @ (moment_b - moment_a_at_b)
    return np.concatenate((force, moment))
