"""Contacts as level 0 of the hierarchy: the velocity must not violate them."""

from __future__ import annotations

import numpy as np

from equipoise.contacts import ContactSchedule, ContactStack
from equipoise.hqp import Rows
from equipoise.kinematics import Kinematics
from equipoise.spatial import Array
from equipoise.tasks.base import Task


class ContactTask(Task):
    """Rows `J_phi v = nu_c - rate * phi`: along the contacts, drift of the reference corrected.

    Source: eqs. (13), (16). Differs from the print: instead of projecting the answer of the
    hierarchy afterwards, which can break the inequalities just enforced, the rows are its highest
    level, so that (16) changes nothing any more.
    """

    def __init__(
        self, name: str, contacts: ContactStack | ContactSchedule, *, rate: float = 10.0
    ) -> None:
        super().__init__(name)
        if isinstance(contacts, ContactStack):
            contacts = ContactSchedule(contacts.contacts, {})
        self.schedule = contacts
        self.rate = rate
        self._labels = {stack: _row_names(stack) for stack in contacts.stacks}
        self._all = ContactStack(contacts.contacts)

    @property
    def labels(self) -> tuple[str, ...]:
        """Contact and row, of every contact that ever holds."""
        return _row_names(self._all)

    @property
    def units(self) -> tuple[str, ...]:
        """Metres and radians: what the residual of each row is measured in."""
        multipliers = [unit for contact in self._all.contacts for unit in contact.units]
        return tuple("rad" if unit == "N m" else "m" for unit in multipliers)

    def rows(self, kin: Kinematics, t: float) -> Rows:
        """Return the equality rows of the contacts that hold at time `t` [s]."""
        stack = self.schedule.at(t)
        wanted = stack.rate(kin) - self.rate * stack.residual(kin)
        J_phi = stack.jacobian(kin)
        return Rows(self.name, "m/s, rad/s", self._labels[stack], J_phi, wanted, wanted)

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return the residual phi (r,) of every contact, zero where it does not hold at `t` [s]."""
        held = self.schedule.at(t)
        residuals = held.split(held.residual(kin))
        error = np.zeros(self._all.size)
        for name, residual in residuals.items():
            error[self._all.rows[name]] = residual
        return error


def _row_names(stack: ContactStack) -> tuple[str, ...]:
    return tuple(
        f"{contact.name}/{label}" for contact in stack.contacts for label in contact.labels
    )
