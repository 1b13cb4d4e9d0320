"""The supporting contacts of a stack as the law sees them: who carries the base, at which cost."""

from __future__ import annotations

import numpy as np

from equipoise.contacts import ContactStack
from equipoise.control.base_wrench import least_reaction, reaction_costs
from equipoise.spatial import Array


class Support:
    """Hands the base rows of the law to the supporting contacts of one stack.

    Source: theory of underactuation, after eq. (24); the print puts torque on the base rows.
    """

    def __init__(self, contacts: ContactStack) -> None:
        supporting = [c for c in contacts.contacts if c.supporting]
        self.rows = contacts.supporting_rows
        self._normal_rows = np.array(
            [
                -1 if c.normal_row is None else contacts.rows[c.name].start + c.normal_row
                for c in supporting
            ],
            dtype=np.int64,
        )
        self._ends = np.cumsum([c.size for c in supporting], dtype=np.int64)
        terms = [np.stack(c.reaction_costs()) for c in supporting]
        self._terms = np.hstack(terms) if terms else np.zeros((2, 0))

    def reaction(self, J_phi: Array, u: Array, lam: Array, before: Array) -> Array:
        """Return `F` (k,) that carries the base rows of `u` (nv,), as `distribute_base_wrench`.

        `J_phi` (r, nv) of the whole stack, `lam` (r,) the measured multipliers, `before` (k,) the F
        that acted when they were measured.
        """
        costs, F = np.empty(len(self.rows)), np.empty(len(self.rows))
        reaction_costs(lam, self._normal_rows, self._ends, self._terms, costs)
        least_reaction(J_phi, self.rows, u, costs, lam[self.rows] - before, F)
        return F
