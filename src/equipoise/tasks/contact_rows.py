"""Contacts as level 0 of the hierarchy: the velocity must not violate them."""

from __future__ import annotations

from equipoise.contacts import ContactStack
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

    def __init__(self, name: str, stack: ContactStack, *, rate: float = 10.0) -> None:
        super().__init__(name)
        self.stack = stack
        self.rate = rate
        self._labels = tuple(
            f"{contact.name}/{label}" for contact in stack.contacts for label in contact.labels
        )

    @property
    def labels(self) -> tuple[str, ...]:
        """Contact and row."""
        return self._labels

    @property
    def units(self) -> tuple[str, ...]:
        """Metres and radians: what the residual of each row is measured in."""
        multipliers = [unit for contact in self.stack.contacts for unit in contact.units]
        return tuple("rad" if unit == "N m" else "m" for unit in multipliers)

    def rows(self, kin: Kinematics, t: float) -> Rows:
        """Return the equality rows of all contacts."""
        wanted = self.stack.rate(kin) - self.rate * self.stack.residual(kin)
        J_phi = self.stack.jacobian(kin)
        return Rows(self.name, "m/s, rad/s", self._labels, J_phi, wanted, wanted)

    def error(self, kin: Kinematics, t: float) -> Array:
        """Return the residual phi (r,) of the contacts."""
        return self.stack.residual(kin)
