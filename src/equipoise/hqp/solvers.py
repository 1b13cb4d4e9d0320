"""The solvers by name."""

from __future__ import annotations

from collections.abc import Callable

from equipoise.errors import NameNotFoundError
from equipoise.hqp.active_set import ActiveSet
from equipoise.hqp.cascade import Cascade
from equipoise.hqp.daqp_solver import DaqpSolver
from equipoise.hqp.recursion import Recursion
from equipoise.hqp.solution import HierarchySolver

SOLVERS: dict[str, Callable[[], HierarchySolver]] = {
    "active_set": ActiveSet,
    "cascade": Cascade,
    "daqp": DaqpSolver,
    "recursion": Recursion,
}


def make_solver(name: str) -> HierarchySolver:
    """Return a new solver with its default parameters.

    Raises:
        NameNotFoundError: there is no solver of that name.
    """
    if name not in SOLVERS:
        raise NameNotFoundError("hierarchy solver", name, SOLVERS)
    return SOLVERS[name]()
