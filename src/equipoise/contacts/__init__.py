"""Contacts as holonomic constraints: kinds, their stack, support polygon, possible reactions."""

from equipoise.contacts.base import Contact
from equipoise.contacts.grasp import GraspContact
from equipoise.contacts.reaction import ReactionMargins, reaction_margins
from equipoise.contacts.sole import SoleContact
from equipoise.contacts.stack import ContactStack, StackedContacts
from equipoise.contacts.support import SupportPolygon

__all__ = [
    "Contact",
    "ContactStack",
    "GraspContact",
    "ReactionMargins",
    "SoleContact",
    "StackedContacts",
    "SupportPolygon",
    "reaction_margins",
]
