"""The stack of contacts: J_phi with its pseudo-inverse and projector, drift and residual.

The pseudo-inverse comes from a pivoted QR factorisation of J_phi^T, which shows its rank: redundant
contacts get the least-norm answer, not a division by zero.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from equipoise.contacts.base import Contact
from equipoise.contacts.factor import factorise_alone, lift_alone, project_alone
from equipoise.errors import InputError, NameNotFoundError
from equipoise.kinematics import Kinematics
from equipoise.spatial import Array

RANK_TOLERANCE = 1e-9


class ContactStack:
    """The contacts of one moment, in a fixed order, with the place of each in the rows."""

    def __init__(self, contacts: Sequence[Contact]) -> None:
        names = [contact.name for contact in contacts]
        if len(set(names)) != len(names):
            raise InputError("two contacts share a name", given=names)
        self.contacts = tuple(contacts)
        ends = np.cumsum([0, *(contact.size for contact in contacts)])
        self.rows = {
            name: slice(int(a), int(b))
            for name, a, b in zip(names, ends[:-1], ends[1:], strict=True)
        }
        self.size = int(ends[-1])
        self.regulated_rows = np.array(
            [
                self.rows[contact.name].start + contact.labels.index(label)
                for contact in contacts
                for label in contact.regulated
            ],
            dtype=int,
        )
        self.supporting_rows = np.concatenate(
            [
                np.arange(self.rows[c.name].start, self.rows[c.name].stop)
                for c in contacts
                if c.supporting
            ]
            or [np.zeros(0, dtype=int)]
        )

    def __getitem__(self, name: str) -> Contact:
        for contact in self.contacts:
            if contact.name == name:
                return contact
        raise NameNotFoundError("contact", name, self.rows)

    def split(self, lam: Array) -> dict[str, Array]:
        """Return the part of a stacked multiplier (r,) that belongs to each contact."""
        return {name: lam[rows] for name, rows in self.rows.items()}

    def at(self, kin: Kinematics) -> StackedContacts:
        """Return the stack evaluated at the state of `kin`."""
        return StackedContacts(self, kin)

    def jacobian(self, kin: Kinematics) -> Array:
        """Return `J_phi` (r, nv)."""
        parts = [contact.jacobian(kin) for contact in self.contacts]
        return np.vstack([np.zeros((0, kin.robot.nv)), *parts])

    def rate(self, kin: Kinematics) -> Array:
        """Return `nu_c` (r,), the right-hand side of `J_phi v = nu_c`."""
        return np.concatenate([np.zeros(0), *(c.rate(kin) for c in self.contacts)])

    def residual(self, kin: Kinematics) -> Array:
        """Return `phi` (r,)."""
        return np.concatenate([np.zeros(0), *(c.residual(kin) for c in self.contacts)])

    def drift(self, kin: Kinematics) -> Array:
        """Return `dJ_phi/dt v - d rate/dt` (r,)."""
        return np.concatenate([np.zeros(0), *(c.drift(kin) for c in self.contacts)])

    def contradictions(self, kin: Kinematics, tolerance: float = 1e-6) -> tuple[str, ...]:
        """Return the contacts that cannot hold together with those before them, none if all can.

        A contact is named if no velocity gives it its rate, or no small step closes its gap
        (more than `tolerance` [m/s, m, ...] is left), while the ones before it keep theirs.
        """
        found, kept = [], ContactStack([])
        for contact in self.contacts:
            grown = ContactStack([*kept.contacts, contact])
            J = grown.jacobian(kin)
            wanted = np.column_stack((grown.rate(kin), -grown.residual(kin)))
            left = J @ np.linalg.lstsq(J, wanted, rcond=RANK_TOLERANCE)[0] - wanted
            if np.abs(left).max() > tolerance:
                found.append(contact.name)
            else:
                kept = grown
        return tuple(found)


class StackedContacts:
    """`J_phi` at one state, with `Q_phi` and `J_phi^+` as operators.

    Source: section III-B. Differs from the print: `J_phi^+` is the Moore-Penrose inverse for any
    rank; where the rank is full it is the paper's `J_phi^T (J_phi J_phi^T)^-1`.
    """

    def __init__(self, stack: ContactStack, kin: Kinematics) -> None:
        self.stack = stack
        self.factor = Factor(stack.size, kin.robot.nv)
        self.J_phi = stack.jacobian(kin)
        self.factor.refresh(self.J_phi)

    @property
    def rank(self) -> int:
        """The number of rows that do not depend on others."""
        return self.factor.rank

    def project(self, v: Array) -> Array:
        """Return `Q_phi v` (nv,), the part that violates no contact. Source: eq. (16)."""
        return self.factor.project(v)

    @property
    def Q_phi(self) -> Array:
        """The projector `I - J_phi^+ J_phi` (nv, nv) as a matrix. Source: eq. (12) for J_phi."""
        return np.column_stack([self.project(e) for e in np.eye(self.J_phi.shape[1])])

    def lift(self, y: Array) -> Array:
        """Return `J_phi^+ y` (nv,): the least velocity with `J_phi v = y`, in least squares."""
        return self.factor.lift(y)

    @property
    def J_phi_pinv(self) -> Array:
        """The pseudo-inverse `J_phi^+` (nv, r) as a matrix."""
        return np.column_stack([self.lift(e) for e in np.eye(self.J_phi.shape[0])])


class Factor:
    """The factorisation of one set of rows `J` (r, nv), in memory that the next one reuses."""

    def __init__(self, size: int, nv: int) -> None:
        self.rank = 0
        self.L = np.zeros((size, nv))
        self.reflectors = np.zeros((size, nv))
        self.pivots = np.zeros(size, dtype=np.int64)

    def refresh(self, J: Array) -> None:
        """Factorise `J` (r, nv)."""
        self.rank = factorise_alone(J, self.L, self.reflectors, self.pivots, RANK_TOLERANCE)

    def project(self, v: Array) -> Array:
        """Return the part of `v` (nv,) that no row sees."""
        out = np.empty(len(v))
        project_alone(self.reflectors, self.rank, v, out)
        return out

    def lift(self, y: Array) -> Array:
        """Return the least `v` (nv,) with `J v = y` (r,), in least squares."""
        out = np.empty(self.L.shape[1])
        lift_alone(self.L, self.reflectors, self.pivots, self.rank, y, out)
        return out
