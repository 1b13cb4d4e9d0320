"""The solvers by name; a solver's library is loaded when it is asked for."""

from __future__ import annotations

from collections.abc import Callable

from equipoise.errors import NameNotFoundError
from equipoise.hqp.solution import HierarchySolver


def _active_set() -> HierarchySolver:
    from equipoise.hqp.solvers.active_set.solver import ActiveSet

    return ActiveSet()


def _cascade() -> HierarchySolver:
    from equipoise.hqp.solvers.cascade import Cascade

    return Cascade()


def _daqp() -> HierarchySolver:
    from equipoise.hqp.solvers.daqp_solver import DaqpSolver

    return DaqpSolver()


def _recursion() -> HierarchySolver:
    from equipoise.hqp.solvers.recursion import Recursion

    return Recursion()


SOLVERS: dict[str, Callable[[], HierarchySolver]] = {
    "active_set": _active_set,
    "cascade": _cascade,
    "daqp": _daqp,
    "recursion": _recursion,
}


def make_solver(name: str) -> HierarchySolver:
    """Return a new solver with its default parameters.

    Raises:
        NameNotFoundError: there is no solver of that name.
    """
    if not isinstance(name, str) or name not in SOLVERS:
        raise NameNotFoundError("hierarchy solver", name, SOLVERS)
    return SOLVERS[name]()
