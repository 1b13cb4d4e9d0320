"""Contacts as level 0 of the hierarchy: the velocity must not violate them."""

from __future__ import annotations

from typing import Self

import numpy as np

from equipoise.contacts import ContactSchedule, ContactStack
from equipoise.errors import InputError
from equipoise.given import require_kind
from equipoise.hqp import Block, Hierarchy, RowDescription, Rows
from equipoise.kinematics import Kinematics
from equipoise.spatial import Array
from equipoise.tasks.base import Task, require_rate


class ContactTask(Task):
    """Rows `J_phi v = nu_c - rate * phi`: along the contacts, drift of the reference corrected.

    In a tick the rows come from the contacts' own kernels (see `motion.program`).
    Source: eqs. (13), (16). Differs from the print: instead of projecting the answer of the
    hierarchy afterwards, which can break the inequalities just enforced, the rows are its highest
    level, so that (16) changes nothing any more.
    """

    row_unit = "m/s, rad/s"

    def __init__(
        self, name: str, contacts: ContactStack | ContactSchedule, *, rate: float = 10.0
    ) -> None:
        super().__init__(name)
        if isinstance(contacts, ContactStack):
            contacts = ContactSchedule(contacts.contacts, {})
        require_kind(
            f"what task {name!r} holds", contacts, ContactSchedule, "A ContactStack will do"
        )
        self.schedule = contacts
        self.rate = require_rate(name, rate)
        self.stack = ContactStack(contacts.contacts)

    def weighing(self, weight: float) -> Self:
        """Refuse: contacts hold or do not. Raises: `InputError`."""
        raise InputError(
            f"contacts hold or do not: task {self.name!r} has no weight",
            given=weight,
            remedy="Give it a level of its own, the highest",
        )

    def easing(self, ease: float) -> Self:
        """Refuse: contacts hold or do not. Raises: `InputError`."""
        raise InputError(
            f"contacts hold or do not: task {self.name!r} has no ease",
            given=ease,
            remedy="Ease what stands below it",
        )

    @property
    def labels(self) -> tuple[str, ...]:
        """Contact and row, of every contact that ever holds."""
        return _row_names(self.stack)

    @property
    def units(self) -> tuple[str, ...]:
        """Metres and radians: what the residual of each row is measured in."""
        multipliers = [unit for contact in self.stack.contacts for unit in contact.units]
        return tuple("rad" if unit == "N m" else "m" for unit in multipliers)

    def rows(self, kin: Kinematics, t: float) -> Rows:
        """Return the equality rows of the contacts that hold at time `t` [s]."""
        held = self.schedule.at(t)
        bound = held.rate(kin) - self.rate * held.residual(kin)
        return Rows(
            self.name, self.row_unit, _row_names(held), held.jacobian(kin), bound, bound.copy()
        )

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return the residual phi (r,) of every contact, zero where it does not hold at `t` [s]."""
        held = self.schedule.at(t)
        error = np.zeros(self.stack.size)
        for name, residual in held.split(held.residual(kin)).items():
            error[self.stack.rows[name]] = residual
        return error

    def describe(self, block: Block, hierarchy: Hierarchy) -> tuple[RowDescription, ...]:
        """Return what a person calls each row."""
        units = dict(zip(self.labels, self.units, strict=True))
        return tuple(
            RowDescription.both(
                f"the contact {label.split('/')[0]}", f"{units[label]}/s", self.rate
            )
            for label in block.labels
        )


def _row_names(stack: ContactStack) -> tuple[str, ...]:
    return tuple(
        f"{contact.name}/{label}" for contact in stack.contacts for label in contact.labels
    )
