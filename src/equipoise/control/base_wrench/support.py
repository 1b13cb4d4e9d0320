"""The supporting contacts of a stack as the law sees them: who carries the base, at which cost."""

from __future__ import annotations

import numpy as np

from equipoise.contacts import ContactStack


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
