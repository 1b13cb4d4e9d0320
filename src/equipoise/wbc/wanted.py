"""What is wanted of each regulated row: scalars of time, numbers that can be set, never a pull."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from equipoise.contacts import Contact, ContactStack
from equipoise.contacts.pull import least_wanted, refuse_pull
from equipoise.errors import InputError, NameNotFoundError
from equipoise.spatial import Array
from equipoise.trajectories import LiveScalar
from equipoise.trajectories.scalar import GIVEN
from equipoise.trajectories.scalars import Scalar, kind_of, least_of, value_of


class WantedForces:
    """The scalars of the regulated rows of all `contacts` that ever hold, in their order.

    `wanted` gives by contact one for each of its rows. `rows` says by "contact/row" the number of
    its scalar, `least` what may be wanted of it. A contact that can only push is never wanted to
    pull: a profile that does is refused, a function of one's own gets zero instead, and `refused`
    tells when it first did. Raises: `InputError`, `NameNotFoundError`.
    """

    def __init__(self, contacts: Sequence[Contact], wanted: Mapping[str, Sequence[Scalar]]) -> None:
        names = [contact.name for contact in contacts]
        for name in wanted:
            if name not in names:
                raise NameNotFoundError("contact", name, names)
        self.scalars: list[Scalar] = []
        self.rows: dict[str, int] = {}
        self.least = least_wanted(contacts)
        self.refused: dict[str, str] = {}
        for contact in contacts:
            self._take(contact, list(wanted.get(contact.name, ())))
        self.live = [one for one in self.scalars if isinstance(one, LiveScalar)]
        self._given = [k for k, one in enumerate(self.scalars) if kind_of(one) == GIVEN]
        self._names, self._least = [*self.rows], [*self.least.values()]

    def _take(self, contact: Contact, given: list[Scalar]) -> None:
        if len(given) != len(contact.regulated):
            raise InputError(
                f"contact {contact.name!r} has {len(contact.regulated)} regulated rows, and "
                f"{len(given)} wanted forces were given",
                known=contact.regulated,
                remedy="Give a wanted force for each regulated row, in their order",
            )
        for label, scalar in zip(contact.regulated, given, strict=True):
            row = f"{contact.name}/{label}"
            refuse_pull(row, self.least[row], least_of(scalar))
            self.rows[row] = len(self.scalars)
            self.scalars.append(scalar)

    def of(self, stack: ContactStack) -> list[int]:
        """Return the numbers of the scalars of contacts that hold, in the order of their rows."""
        return [
            self.rows[f"{contact.name}/{label}"]
            for contact in stack.contacts
            for label in contact.regulated
        ]

    def write(self, values: Array, t: float) -> None:
        """Write into `values` (k,) what only Python knows of time `t` [s], and take what was set.

        The kernel evaluates the others.
        """
        for k in self._given:
            values[k] = value_of(self.scalars[k], t)
            if values[k] < self._least[k]:
                row = self._names[k]
                told = f"t = {t:.3f} s: {row} was wanted to pull ({values[k]:g}); it gets 0"
                self.refused.setdefault(row, told)
        for live in self.live:
            live.post()

    def set(self, row: str, value: float) -> None:
        """Set a number from the next tick on: see `WholeBodyController.want`."""
        rows = [one for one in self.rows if row in (one, one.split("/")[0])]
        if len(rows) != 1:
            raise NameNotFoundError("regulated row", row, self.rows)
        scalar = self.scalars[self.rows[rows[0]]]
        if not isinstance(scalar, LiveScalar):
            raise InputError(
                f"the wanted force of {rows[0]} is a function of time and cannot be set",
                remedy="Give it as a number or as a `LiveScalar`",
            )
        refuse_pull(rows[0], self.least[rows[0]], value)
        scalar.set(value)
