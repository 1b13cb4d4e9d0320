"""Which contacts hold when: a stack for every stretch of time between changes."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping, Sequence

import numpy as np

from equipoise.contacts.base import Contact
from equipoise.contacts.stack import ContactStack

ALWAYS = (-np.inf, np.inf)


class ContactSchedule:
    """Stacks over time. `windows[name] = (start, end)` [s]; a contact without one always holds."""

    def __init__(
        self, contacts: Sequence[Contact], windows: Mapping[str, tuple[float, float]]
    ) -> None:
        changes = sorted({t for window in windows.values() for t in window if np.isfinite(t)})
        self.contacts = tuple(contacts)
        self.windows = {c.name: windows.get(c.name, ALWAYS) for c in contacts}
        self._starts = [-np.inf, *changes]
        self._stacks: list[ContactStack] = []
        for start in self._starts:
            held = [c for c in contacts if self._holds(c, start)]
            self._stacks.append(ContactStack(held))

    @property
    def stacks(self) -> tuple[ContactStack, ...]:
        """The stacks, in the order of time."""
        return tuple(self._stacks)

    @property
    def changes(self) -> tuple[float, ...]:
        """When each stack begins to hold [s]."""
        return tuple(self._starts)

    def at(self, t: float) -> ContactStack:
        """Return the stack that holds at time `t` [s]; the same object between two changes."""
        return self._stacks[bisect_right(self._starts, t) - 1]

    def _holds(self, contact: Contact, t: float) -> bool:
        start, end = self.windows[contact.name]
        return start <= t < end
