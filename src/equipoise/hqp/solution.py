"""Solution: what a hierarchy solver answers, with residuals computed here and by nobody else."""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple, Protocol

import numpy as np

from equipoise.hqp.certificate import Certificate, certify
from equipoise.hqp.hierarchy import Hierarchy

ACTIVE_TOLERANCE = 1e-8
EQUALITY, UPPER, LOWER, INACTIVE = 2, 1, -1, 0


class Status(Enum):
    """How a solver ended; the value is a sentence."""

    SOLVED = "Every level was minimised."
    ITERATION_LIMIT = (
        "The iteration limit came first: the levels above keep their optimum, the last one may not."
    )
    FAILED = "The solver gave no usable answer: v is not to be trusted."


class Solution(NamedTuple):
    """An answer to a hierarchy.

    `v` [n]; `w` [m], the violation of each row, `A v - clip(A v, lower, upper)`; `slack`, the
    Euclidean norm of w on each level; `active` [m], -1 at or below the lower bound, +1 at or above
    the upper, 2 equality, 0 inactive; `status`; `solver`, its name; `iterations`.
    """

    v: np.ndarray
    w: np.ndarray
    slack: tuple[float, ...]
    active: np.ndarray
    status: Status
    solver: str
    iterations: int

    @property
    def solved(self) -> bool:
        """Whether every level was minimised, as far as the solver knows."""
        return self.status is Status.SOLVED

    def certificate(self, hierarchy: Hierarchy) -> Certificate:
        """Check the answer against the optimality conditions, independently of the solver."""
        return certify(hierarchy, self.v)


class HierarchySolver(Protocol):
    """Anything that answers hierarchies."""

    @property
    def name(self) -> str:
        """What the solver is called."""

    def solve(self, hierarchy: Hierarchy) -> Solution:
        """Return the answer; a numerical outcome is a status, never an exception."""
        ...


def violation(hierarchy: Hierarchy, v: np.ndarray) -> np.ndarray:
    """Return `A v - clip(A v, lower, upper)` [m]."""
    values = hierarchy.A @ v
    return values - np.minimum(np.maximum(values, hierarchy.lower), hierarchy.upper)


def describe(
    hierarchy: Hierarchy, v: np.ndarray, status: Status, solver: str, iterations: int
) -> Solution:
    """Put an answer v [n] together with residuals computed from it.

    A v that is not finite becomes the status FAILED, with zero velocity and infinite residuals.
    """
    m = len(hierarchy.lower)
    if not np.isfinite(v).all():
        infinite = (np.inf,) * len(hierarchy.ends)
        nothing = np.zeros(hierarchy.n), np.full(m, np.inf), infinite, np.zeros(m, dtype=np.int8)
        return Solution(*nothing, Status.FAILED, solver, iterations)
    values = hierarchy.A @ v
    lower, upper = hierarchy.lower, hierarchy.upper
    w = values - np.minimum(np.maximum(values, lower), upper)
    squares = w * w
    slack, start = [], 0
    for end in hierarchy.ends:
        slack.append(float(squares[start:end].sum()) ** 0.5)
        start = end
    active = _active(values, lower, upper)
    return Solution(v, w, tuple(slack), active, status, solver, iterations)


def _active(values: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    margin = ACTIVE_TOLERANCE * (1.0 + np.abs(values))
    active = (values >= upper - margin).astype(np.int8)
    active -= values <= lower + margin
    active[lower == upper] = EQUALITY
    return active
