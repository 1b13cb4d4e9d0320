"""Seeded random hierarchies of every awkward kind, for the tests of the solvers."""

from __future__ import annotations

import numpy as np

from equipoise.hqp import Hierarchy, Rows

KINDS = ("feasible", "infeasible", "redundant", "degenerate", "badly scaled", "boxes")


def block(
    name: str, A: np.ndarray, lower: np.ndarray, upper: np.ndarray, unit: str = "m/s"
) -> Rows:
    """Return a block with numbered labels."""
    return Rows(name, unit, tuple(f"{name}{r}" for r in range(len(A))), A, lower, upper)


def equalities(name: str, A: np.ndarray, target: np.ndarray) -> Rows:
    """Return a block `A v = target`."""
    return block(name, A, target, target)


def random_hierarchy(
    kind: str, seed: int, n: int | None = None, unit_rows: bool = False
) -> Hierarchy:
    """Return a hierarchy of 2 to 5 levels, 5 to 40 unknowns unless n is given."""
    rng = np.random.default_rng([KINDS.index(kind), seed])
    n = n or int(rng.integers(5, 41))
    v = rng.normal(size=n)
    levels, seen = [], np.empty((0, n))
    for i in range(int(rng.integers(2, 6))):
        rows = max(2, int(rng.integers(n // 4, n // 2 + 2)))
        A = rng.normal(size=(rows, n))
        if kind == "boxes" and i % 2:
            A = np.eye(n)[rng.permutation(n)[: max(rows, 3 * n // 4)]]
        if kind in ("redundant", "degenerate"):
            A = _with_repeats(A, seen, rng)
        if kind == "badly scaled":
            A = A * 10.0 ** (rng.uniform(-3.0, 3.0) + rng.uniform(-1.0, 1.0, size=(len(A), 1)))
        if unit_rows:
            A = A / np.linalg.norm(A, axis=1)[:, None]
        seen = np.vstack([seen, A])
        levels.append([_bounded(f"l{i}", A, v, kind, rng)])
    return Hierarchy.stack(levels, n)


def _with_repeats(A: np.ndarray, seen: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    A = A.copy()
    A[-1] = A[:-1].T @ rng.normal(size=len(A) - 1)
    if len(A) > 3:
        A[-2] = -2.0 * A[0]
    if len(seen):
        A[1] = seen.T @ rng.normal(size=len(seen))
        A[0] = seen[rng.integers(len(seen))]
    return A


def _bounded(name: str, A: np.ndarray, v: np.ndarray, kind: str, rng: np.random.Generator) -> Rows:
    m = len(A)
    norms = np.linalg.norm(A, axis=1)
    centre = A @ v
    if kind not in ("feasible", "degenerate"):
        off = rng.normal(size=m) * norms * np.sqrt(A.shape[1]) * 0.5
        centre = centre + off * (rng.random(m) < 0.7)
    below = rng.exponential(size=m) * norms
    above = rng.exponential(size=m) * norms
    if kind == "degenerate":  # many bounds meet in one point, which is v
        side = rng.random(m)
        below, above = below * (side < 0.6), above * (side > 0.4)
    lower, upper = centre - below, centre + above
    lower[rng.random(m) < 0.3] = -np.inf
    upper[rng.random(m) < 0.3] = np.inf
    equal = rng.random(m) < 0.4
    lower[equal] = upper[equal] = centre[equal]
    return block(name, A, lower, upper)
