"""The hierarchy room: rows in, their lexicographic optimum out. It knows no robot."""

from equipoise.hqp.certificate import Certificate, LevelCertificate, certify
from equipoise.hqp.hierarchy import Block, Hierarchy
from equipoise.hqp.rows import Rows
from equipoise.hqp.solution import HierarchySolver, Solution, Status, violation
from equipoise.hqp.solvers import SOLVERS, make_solver

__all__ = [
    "SOLVERS",
    "Block",
    "Certificate",
    "Hierarchy",
    "HierarchySolver",
    "LevelCertificate",
    "Rows",
    "Solution",
    "Status",
    "certify",
    "make_solver",
    "violation",
]
