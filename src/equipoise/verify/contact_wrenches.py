"""What the multipliers of a contact do to the bodies, said again for each kind without its rows."""

from __future__ import annotations

from functools import singledispatch
from typing import NamedTuple

import numpy as np

from equipoise.contacts import Contact, GraspContact, PointContact, SoleContact
from equipoise.contacts.sliding import SlidingContact
from equipoise.kinematics import Kinematics
from equipoise.spatial import Array


class Wrench(NamedTuple):
    """Force [N] (3,) at a point [m] (3,) and moment [N m] (3,), world axes, on a frame's body."""

    frame: str | int
    p_world: Array
    force: Array
    moment: Array


@singledispatch
def wrenches_of(contact: Contact, kin: Kinematics, lam: Array) -> list[Wrench]:
    """Return the wrenches that the multipliers `lam` (k,) of a contact exert on the bodies."""
    raise NotImplementedError(type(contact).__name__)


@wrenches_of.register
def _of_sole(contact: SoleContact, kin: Kinematics, lam: Array) -> list[Wrench]:
    R = contact.T_world_anchor.rotation
    p_world = kin.placement(contact.sole.frame).translation
    return [Wrench(contact.sole.frame, p_world, R @ lam[:3], R @ lam[3:])]


@wrenches_of.register
def _of_grasp(contact: GraspContact, kin: Kinematics, lam: Array) -> list[Wrench]:
    R = kin.placement(contact.frame_a).rotation
    p_world = kin.placement(contact.frame_b).translation
    force, moment = R @ lam[:3], R @ lam[3:]
    return [
        Wrench(contact.frame_b, p_world, force, moment),
        Wrench(contact.frame_a, p_world, -force, -moment),
    ]


@wrenches_of.register
def _of_point(contact: PointContact, kin: Kinematics, lam: Array) -> list[Wrench]:
    p_world = kin.placement(contact.frame).act(np.array(contact.offset))
    return [Wrench(contact.frame, p_world, lam, np.zeros(3))]


@wrenches_of.register
def _of_surface(contact: SlidingContact, kin: Kinematics, lam: Array) -> list[Wrench]:
    p_world = kin.placement(contact.frame).act(np.array(contact.offset))
    return [Wrench(contact.frame, p_world, contact.normal(kin) * lam[0], np.zeros(3))]
