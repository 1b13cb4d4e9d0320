"""Which of the multipliers of all contacts belong to those that hold."""

from __future__ import annotations

import numpy as np

from equipoise.contacts import ContactStack
from equipoise.spatial import Array


class HeldRows:
    """Finds the rows of stacks in the stack of all contacts."""

    def __init__(self, contacts: ContactStack) -> None:
        self._contacts = contacts
        self._rows: dict[ContactStack, Array] = {}

    def rows(self, held: ContactStack) -> Array:
        """Return the rows (k,) of the contacts that hold, in their order."""
        rows = self._rows.get(held)
        if rows is None:
            parts = [np.r_[self._contacts.rows[contact.name]] for contact in held.contacts]
            rows = self._rows[held] = np.concatenate([np.zeros(0, dtype=int), *parts])
        return rows
