"""The hierarchy solvers, one file or folder each, by name in the registry."""

from equipoise.hqp.solvers.registry import SOLVERS, make_solver

__all__ = ["SOLVERS", "make_solver"]
