"""Feet of the rigid engine that lift and land: where they are over the ground."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from equipoise.contacts import Contact, PointContact, SoleContact
from equipoise.contacts.support_polygon import sole_corners
from equipoise.kinematics import Kinematics
from equipoise.physics.rigid.ground import Ground
from equipoise.spatial import Array
from equipoise.spatial.numbers import real_number


def lifts(contact: Contact) -> bool:
    """Return whether a contact can come off the floor."""
    return contact.supporting and isinstance(contact, SoleContact | PointContact)


def height(contact: Contact) -> float:
    """Return the height [m] of the lowest point of a foot's anchor."""
    if isinstance(contact, SoleContact):
        return float(sole_corners(contact.sole, contact.T_world_anchor)[:, 2].min())
    assert isinstance(contact, PointContact)
    return real_number("the height of a foot", contact.p_world[2])


def lowest(contact: Contact, kin: Kinematics) -> tuple[float, Array, str | int]:
    """Return height [m] of a foot's lowest point, its middle (3,) [m], and its frame."""
    if isinstance(contact, SoleContact):
        corners = sole_corners(contact.sole, kin.placement(contact.frame))
        return float(corners[:, 2].min()), corners.mean(axis=0), contact.frame
    assert isinstance(contact, PointContact)
    point = kin.placement(contact.frame).act(np.array(contact.offset))
    return float(point[2]), point, contact.frame


def goes_into(ground: Ground, contact: Contact, kin: Kinematics) -> bool:
    """Return whether the lowest point of a foot is at the ground, and its middle goes down."""
    bottom, middle, frame = lowest(contact, kin)
    if bottom > ground.under(middle):
        return False
    twist = kin.twist(frame)
    speed = twist[:3] + np.cross(twist[3:], middle - kin.placement(frame).translation)
    return bool(speed[2] < 0.0)


def landed(contact: Contact, kin: Kinematics) -> Contact:
    """Return the contact of a foot that stands where it is now."""
    if isinstance(contact, SoleContact):
        return replace(contact, T_world_anchor=kin.placement(contact.frame))
    assert isinstance(contact, PointContact)
    T = kin.placement(contact.frame)
    return replace(contact, p_world=T.act(np.array(contact.offset)))
