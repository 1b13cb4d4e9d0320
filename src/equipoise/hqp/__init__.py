"""The hierarchy room: rows in, their lexicographic optimum out. It knows no robot."""

from equipoise.hqp.certificate import Certificate, LevelCertificate, certify
from equipoise.hqp.explain import explain
from equipoise.hqp.explanation import Blocker, Explanation, Shortfall
from equipoise.hqp.hierarchy import Block, Hierarchy
from equipoise.hqp.row_names import RowDescription, plain_descriptions
from equipoise.hqp.rows import Rows
from equipoise.hqp.saved import SavedProblem, load_problem, save_problem
from equipoise.hqp.solution import HierarchySolver, Solution, Status, violation
from equipoise.hqp.solvers import SOLVERS, make_solver

__all__ = [
    "SOLVERS",
    "Block",
    "Blocker",
    "Certificate",
    "Explanation",
    "Hierarchy",
    "HierarchySolver",
    "LevelCertificate",
    "RowDescription",
    "Rows",
    "SavedProblem",
    "Shortfall",
    "Solution",
    "Status",
    "certify",
    "explain",
    "load_problem",
    "make_solver",
    "plain_descriptions",
    "save_problem",
    "violation",
]
