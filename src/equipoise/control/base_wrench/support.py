"""The supporting contacts of a stack as the law sees them: who carries the base, at which cost."""

from __future__ import annotations

import numpy as np

from equipoise.contacts import Contact, ContactStack, SoleContact
from equipoise.spatial import Array


class Support:
    """What `reaction_costs` needs to know of the supporting contacts of one stack."""

    def __init__(self, contacts: ContactStack) -> None:
        supporting = [c for c in contacts.contacts if c.supporting]
        self.contacts = tuple(supporting)
        self.normal_rows = np.array(
            [
                -1 if c.normal_row is None else contacts.rows[c.name].start + c.normal_row
                for c in supporting
            ],
            dtype=np.int64,
        )
        self.ends = np.cumsum([c.size for c in supporting], dtype=np.int64)
        terms = [np.stack(c.reaction_costs()) for c in supporting]
        self.terms = np.hstack(terms) if terms else np.zeros((2, 0))
        self.centres = np.array([_centre(c) for c in supporting]).reshape(-1, 2)


def _centre(contact: Contact) -> Array:
    """Return where the middle of a support is (2,) [m], along its first two axes."""
    if not isinstance(contact, SoleContact):
        return np.zeros(2)
    sole = contact.sole
    return 0.5 * np.array([sole.x_min + sole.x_max, sole.y_min + sole.y_max])
