"""Contacts as level 0 of the hierarchy: the velocity must not violate them."""

from __future__ import annotations

import numpy as np

from equipoise.compiled.compilation import entrance
from equipoise.contacts import ContactRows, ContactSchedule, ContactStack
from equipoise.kinematics import Kinematics
from equipoise.spatial import Array
from equipoise.tasks.base import CompiledTask


class ContactTask(CompiledTask):
    """Rows `J_phi v = nu_c - rate * phi`: along the contacts, drift of the reference corrected.

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
        self.schedule = contacts
        self.rate = rate
        self._labels = {stack: _row_names(stack) for stack in contacts.stacks}
        self._all = ContactStack(contacts.contacts)
        self._rows: dict[ContactStack, ContactRows] = {}

    @property
    def labels(self) -> tuple[str, ...]:
        """Contact and row, of every contact that ever holds."""
        return _row_names(self._all)

    @property
    def units(self) -> tuple[str, ...]:
        """Metres and radians: what the residual of each row is measured in."""
        multipliers = [unit for contact in self._all.contacts for unit in contact.units]
        return tuple("rad" if unit == "N m" else "m" for unit in multipliers)

    def row_labels(self, t: float) -> tuple[str, ...]:
        """Return contact and row of those that hold at time `t` [s]."""
        return self._labels[self.schedule.at(t)]

    def fill(
        self, kin: Kinematics, t: float, A: Array, lower: Array, upper: Array, at: int
    ) -> None:
        """Write the equality rows of the contacts that hold at time `t` [s]."""
        stack = self.schedule.at(t)
        rows = self._rows.get(stack)
        if rows is None:
            rows = self._rows[stack] = ContactRows.of_size(stack.size, kin.robot.nv)
        stack.fill(kin, rows)
        contact_task_rows(rows.J, rows.rate, rows.residual, self.rate, A, lower, upper, at)

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return the residual phi (r,) of every contact, zero where it does not hold at `t` [s]."""
        held = self.schedule.at(t)
        residuals = held.split(held.residual(kin))
        error = np.zeros(self._all.size)
        for name, residual in residuals.items():
            error[self._all.rows[name]] = residual
        return error


@entrance
def contact_task_rows(
    J: np.ndarray,
    contact_rate: np.ndarray,
    residual: np.ndarray,
    rate: float,
    A: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    at: int,
) -> None:
    """Write `J_phi v = nu_c - rate * phi`."""
    for i in range(J.shape[0]):
        for c in range(J.shape[1]):
            A[at + i, c] = J[i, c]
        lower[at + i] = contact_rate[i] - rate * residual[i]
        upper[at + i] = lower[at + i]


def _row_names(stack: ContactStack) -> tuple[str, ...]:
    return tuple(
        f"{contact.name}/{label}" for contact in stack.contacts for label in contact.labels
    )
