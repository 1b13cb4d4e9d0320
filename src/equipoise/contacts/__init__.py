"""Contacts as holonomic constraints: kinds, their stack, support polygon, possible reactions."""

from equipoise.contacts.base import Contact, KernelContact
from equipoise.contacts.grasp import GraspContact
from equipoise.contacts.moving import (
    MotionSample,
    MovingSurfaceContact,
    StraightMotion,
    SurfaceMotion,
)
from equipoise.contacts.phases import ContactPhases, Phase, PhaseChange, PhaseSettings, load_of
from equipoise.contacts.point import PointContact
from equipoise.contacts.schedule import ContactSchedule
from equipoise.contacts.sole import SoleContact
from equipoise.contacts.stack import ContactStack, Factor, StackedContacts
from equipoise.contacts.support_polygon import SupportPolygon
from equipoise.contacts.surface import SurfaceContact
from equipoise.contacts.wrench_cone import ReactionMargins, margins_of, outline, reaction_margins

__all__ = [
    "Contact",
    "ContactPhases",
    "ContactSchedule",
    "ContactStack",
    "Factor",
    "GraspContact",
    "KernelContact",
    "MotionSample",
    "MovingSurfaceContact",
    "Phase",
    "PhaseChange",
    "PhaseSettings",
    "PointContact",
    "ReactionMargins",
    "SoleContact",
    "StackedContacts",
    "StraightMotion",
    "SupportPolygon",
    "SurfaceContact",
    "SurfaceMotion",
    "load_of",
    "margins_of",
    "outline",
    "reaction_margins",
]
