"""What the floor can give: bounds of the supporting forces, and a wrench shared out within them."""

from __future__ import annotations

import numpy as np

from equipoise.contacts import ContactStack
from equipoise.control.base_wrench.foot_bounds import ReactionBounds, bounds_of, require_feet
from equipoise.control.rivals.quadratic import minimise
from equipoise.spatial import Array

SHORTFALL = 1e4  # what a newton of the wrench that no force gives costs, beside costs near 1


class Floor:
    """Costs (k,) of the supporting forces of a stack, and their bounds `A F >= b`.

    The same rows that the shipped law's bounded distribution keeps: pressing, friction cones as
    pyramids of eight sides, centre of pressure and yaw moment of a sole.
    Source: Caron, Pham and Nakamura 2015 (wrench cone of a rectangle).
    Raises: `InputError` if a supporting contact is neither sole nor point.
    """

    def __init__(self, contacts: ContactStack, bounds: ReactionBounds | None = None) -> None:
        feet = require_feet([c for c in contacts.contacts if c.supporting])
        rows = [bounds_of(foot, bounds or ReactionBounds()) for foot in feet]
        self.size = sum(foot.size for foot in feet)
        self.costs = np.concatenate([np.zeros(0), *(sum(foot.reaction_costs()) for foot in feet)])
        self.A = np.zeros((sum(len(part.A) for part in rows), self.size))
        row = column = 0
        for part in rows:
            k, n = part.A.shape
            self.A[row : row + k, column : column + n] = part.A
            row, column = row + k, column + n
        self.b = np.concatenate([np.zeros(0), *(part.b for part in rows)])

    def least(self, wrench: Array, J_base: Array) -> Array:
        """Return the F (k,) of least cost with `J_base^T F = wrench` (b,), whatever its bounds."""
        weighted = J_base.T / self.costs**2
        return weighted.T @ np.linalg.solve(weighted @ J_base, wrench)

    def within_bounds(self, wrench: Array, J_base: Array) -> Array:
        """Return the F (k,) of least cost within the bounds, with as much of the wrench as goes."""
        k, b = self.size, len(wrench)
        metric = np.concatenate((self.costs, np.full(b, SHORTFALL)))
        equal = np.hstack((J_base.T, np.eye(b))), wrench
        bounds = (
            np.hstack((self.A, np.zeros((len(self.b), b)))),
            self.b,
            np.full(len(self.b), np.inf),
        )
        return minimise(metric, np.zeros(k + b), equal, bounds).x[:k]
