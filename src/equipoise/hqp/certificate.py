"""Certificate: whether a v is the lexicographic optimum, whoever says so.

On each level i the violation w_i is least if and only if multipliers of the rows above exist with
A_i^T w_i + sum_j A_j^T lam_j = 0, where lam is free for equalities and violated rows, >= 0 at an
upper bound, <= 0 at a lower bound and zero elsewhere. The multipliers are found here by
non-negative least squares, and weak duality turns them into a bound on what is left to gain.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from equipoise.hqp.hierarchy import Hierarchy

RANK_TOLERANCE = 1e-11
NEARLY_DEPENDENT = 1e-8  # below it balancing the rest would shift the multipliers, not mend them
BALANCE_TOLERANCE = 1e-9  # multipliers that leave more of their forces over are refused
REACH = 10.0  # what they leave over is weighed for every optimum within this many times |v|


@dataclass(frozen=True, slots=True)
class LevelCertificate:
    """The check of one level; the last one of a `Certificate` checks the least norm of v.

    `slack` |w_i|; `residual`, the part of A_i^T w_i that no multipliers balance, relative to
    |A_i| times the size of A_i v, w_i and the bounds; `excess`, a bound on |w_i| - |w_i*| (never
    above |w_i| itself); `scale`, the size it is to be compared with; `multipliers` [rows above],
    in the units (unit of w_i)^2 / (unit of the row).
    """

    slack: float
    residual: float
    excess: float
    scale: float
    multipliers: np.ndarray


@dataclass(frozen=True, slots=True)
class Certificate:
    """The checks of all levels, and last of the least norm."""

    levels: tuple[LevelCertificate, ...]
    least_norm: LevelCertificate

    def holds(self, tolerance: float = 1e-7) -> bool:
        """Tell whether every excess is below `tolerance` times the size of its level."""
        return all(c.excess <= tolerance * c.scale for c in (*self.levels, self.least_norm))

    def __str__(self) -> str:
        named = [(f"level {i}", c) for i, c in enumerate(self.levels)]
        named.append(("least norm", self.least_norm))
        return "\n".join(
            f"{name:<10}  |w| = {c.slack:.3e}, at most {c.excess:.1e} above the optimum, "
            f"stationary to {c.residual:.1e}"
            for name, c in named
        )


def certify(hierarchy: Hierarchy, v: np.ndarray, tolerance: float = 1e-9) -> Certificate:
    """Check v [n] against the optimality conditions of every level.

    `tolerance`, relative to the size of a row's value: how near a bound is at the bound.
    """
    n, ends = hierarchy.n, hierarchy.ends
    if not np.isfinite(v).all():
        lost = [LevelCertificate(np.inf, np.inf, np.inf, 0.0, np.full(e, np.inf)) for e in ends]
        return Certificate(tuple(lost), lost[-1] if lost else _nothing(np.inf))
    rows, reach = _RowsAt(hierarchy, v, tolerance), REACH * float(np.linalg.norm(v))
    levels = [
        _check(rows.part(hierarchy.level(i)), rows.part(slice(0, hierarchy.level(i).start)), reach)
        for i in range(len(ends))
    ]
    zero = np.zeros(n)
    norm = _RowsAt(Hierarchy(np.eye(n), zero, zero, (n,), ()), v, tolerance)
    return Certificate(tuple(levels), _check(norm, rows, reach))


def _nothing(value: float) -> LevelCertificate:
    return LevelCertificate(value, value, value, 0.0, np.empty(0))


class _RowsAt:
    """Rows evaluated at v: values, violations, and which multipliers they may carry."""

    def __init__(self, hierarchy: Hierarchy, v: np.ndarray, tolerance: float) -> None:
        self.A, self.lower, self.upper = hierarchy.A, hierarchy.lower, hierarchy.upper
        self.norms = np.linalg.norm(self.A, axis=1)
        self.values = self.A @ v
        self.w = self.values - np.clip(self.values, self.lower, self.upper)
        self.size = np.maximum(self.norms * np.linalg.norm(v), self._nearest_bounds())
        margin = tolerance * self.size
        self.violated = np.abs(self.w) > margin
        self.equal = self.lower == self.upper
        self.at_upper = ~self.equal & ~self.violated & (self.values >= self.upper - margin)
        self.at_lower = ~self.equal & ~self.violated & (self.values <= self.lower + margin)

    def _nearest_bounds(self) -> np.ndarray:
        return np.abs(np.clip(0.0, self.lower, self.upper))

    def part(self, rows: slice) -> _RowsAt:
        """Return some of the rows."""
        part = object.__new__(_RowsAt)
        for name, value in self.__dict__.items():
            setattr(part, name, value[rows])
        return part


def _check(own: _RowsAt, above: _RowsAt, reach: float) -> LevelCertificate:
    slack = float(np.linalg.norm(own.w))
    scale = float(np.linalg.norm(own.size))
    if not slack > 0.0:
        return LevelCertificate(0.0, 0.0, 0.0, scale, np.zeros(len(above.w)))
    multipliers = _best_multipliers(own, above)
    left = own.A.T @ own.w + above.A.T @ multipliers
    size = float(np.linalg.norm(own.A)) * scale
    residual = float(np.linalg.norm(left)) / size if size > 0.0 else np.inf
    excess = _excess(own, above, multipliers, left, slack, reach)
    return LevelCertificate(slack, residual, excess, scale, multipliers)


def _best_multipliers(own: _RowsAt, above: _RowsAt) -> np.ndarray:
    """Return the multipliers [rows above] of the right signs that balance A^T w best."""
    norms = np.where(above.norms > 0.0, above.norms, 1.0)
    unit = above.A / norms[:, None]
    free = above.equal | above.violated
    signs = np.where(above.at_upper, 1.0, np.where(above.at_lower, -1.0, 0.0))
    signed = signs != 0.0
    gradient = own.A.T @ own.w
    onto_free = _row_space(unit[free])
    outside = -(gradient - onto_free @ (onto_free.T @ gradient))
    cone = (unit[signed] * signs[signed, None]).T
    cone = cone - onto_free @ (onto_free.T @ cone)
    multipliers = np.zeros(len(norms))
    multipliers[signed] = _non_negative(cone, outside) * signs[signed]
    rest = -(gradient + unit[signed].T @ multipliers[signed])
    multipliers[free] = _least_squares(unit[free].T, rest)
    return multipliers / norms


def _non_negative(columns: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Return x >= 0 that brings `columns` [n, k] x nearest to `target` [n]."""
    if not columns.size or not target.any():
        return np.zeros(columns.shape[1])
    from scipy.optimize import lsq_linear, nnls

    size = float(np.linalg.norm(target))
    try:
        return nnls(columns, target / size)[0] * size
    except RuntimeError:  # its iteration limit
        return lsq_linear(columns, target / size, (0.0, np.inf), method="bvls").x * size


def _excess(
    own: _RowsAt,
    above: _RowsAt,
    multipliers: np.ndarray,
    left: np.ndarray,
    slack: float,
    reach: float,
) -> float:
    """Return a bound on |w| - |w*| by weak duality.

    The pair (w, multipliers) is moved to the nearest one (mu, lam) that balances, among
    the own rows, the free rows above and the rows that carry a multiplier. Then
    |w*|^2 / 2 >= -|mu|^2 / 2 + mu . A v - support(mu) + lam . A' v - support'(lam).
    Rounding leaves a little unbalanced, r; it counts with |r| times `reach`.
    """
    norms = np.where(above.norms > 0.0, above.norms, 1.0)
    free = above.equal | above.violated
    carry, broken = free | (multipliers != 0.0), own.w != 0.0
    columns = np.vstack([own.A[broken], above.A[carry] / norms[carry, None]]).T
    change = _least_squares(columns, -left, NEARLY_DEPENDENT)
    split = int(broken.sum())
    mu, lam = own.w.copy(), multipliers.copy()
    mu[broken] += change[:split]
    lam[carry] += change[split:] / norms[carry]
    mu[~own.equal & (mu * own.w < 0.0)] = 0.0
    lam[~free & (lam * multipliers < 0.0)] = 0.0
    forces = float(np.abs(mu) @ own.norms + np.abs(lam) @ above.norms)
    unbalanced = float(np.linalg.norm(own.A.T @ mu + above.A.T @ lam))
    if unbalanced > BALANCE_TOLERANCE * forces:
        return slack
    held_lower = np.where(free, above.values, np.minimum(above.lower, above.values))
    held_upper = np.where(free, above.values, np.maximum(above.upper, above.values))
    gap = 0.5 * float(own.w @ own.w) + 0.5 * float(mu @ mu)
    gap -= _complementary(mu, own.values, own.lower, own.upper)
    gap -= _complementary(lam, above.values, held_lower, held_upper)
    gap += unbalanced * reach
    if not np.isfinite(gap):
        return slack
    best = max(slack**2 - 2.0 * max(gap, 0.0), 0.0)
    return slack - best**0.5


def _complementary(
    multipliers: np.ndarray, values: np.ndarray, lower: np.ndarray, upper: np.ndarray
) -> float:
    """Return sum of multiplier times (value - the bound that it stands for)."""
    carry = multipliers != 0.0
    bound = np.where(multipliers > 0.0, upper, lower)[carry]
    return float(multipliers[carry] @ (values[carry] - bound))


def _row_space(rows: np.ndarray) -> np.ndarray:
    """Return an orthonormal basis [n, r] of the span of unit rows."""
    if not rows.size:
        return np.zeros((rows.shape[1], 0))
    _, s, right = np.linalg.svd(rows, full_matrices=False)
    return right[s > RANK_TOLERANCE * s[0]].T


def _least_squares(
    columns: np.ndarray, target: np.ndarray, tolerance: float = RANK_TOLERANCE
) -> np.ndarray:
    if not columns.size:
        return np.zeros(columns.shape[1])
    return np.linalg.lstsq(columns, target, rcond=tolerance)[0]
