"""Certificate: whether a v is the lexicographic optimum, whoever says so.

On each level i the violation w_i is least if and only if multipliers of the rows above exist with
A_i^T w_i + sum_j A_j^T lam_j = 0, where lam is free for equalities and violated rows, >= 0 at an
upper bound, <= 0 at a lower bound and zero elsewhere. The multipliers are found here by
non-negative least squares. What rounding leaves over is balanced by violations mu_i near w_i, and
that says two things. v is the exact optimum of a hierarchy whose bounds are elsewhere, by
mu_i - w_i: for each row a share of its own size, the `shift`. And weak duality bounds what is left
to gain for the hierarchy as given: the `excess`.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from equipoise.hqp.hierarchy import Hierarchy
from equipoise.optional import require_package

RANK_TOLERANCE = 1e-11
NEARLY_DEPENDENT = 1e-8  # below it balancing the rest would shift the multipliers, not mend them
BALANCE_TOLERANCE = 1e-7  # multipliers that leave more of their forces over are refused
ROUNDING = 1e-12  # a share of the size of a row below which a violation is none
PRECISION = 1e-14  # of the sum of all forces, to which a balance can be known
SMALLEST = 1e-300
REACH = 10.0  # what is left over is weighed for every optimum within this many times |v|
CHEAP = 1e4  # multipliers of rows above may change this many times more than violations


@dataclass(frozen=True, slots=True)
class LevelCertificate:
    """The check of one level; the last one of a `Certificate` checks the least norm of v.

    `slack` |w_i|; `residual`, the part of A_i^T w_i that no multipliers balance, relative to
    |A_i| times the size of A_i v, w_i and the bounds; `excess`, a bound on |w_i| - |w_i*| (never
    above |w_i| itself); `scale`, the size it is to be compared with; `shift`, the largest move of a
    bound, as a share of the size of its row, that makes v the exact optimum; `multipliers` [rows
    above], in the units (unit of w_i)^2 / (unit of the row).
    """

    slack: float
    residual: float
    excess: float
    scale: float
    shift: float
    multipliers: np.ndarray

    def holds(self, tolerance: float) -> bool:
        """Tell whether excess and shift are below `tolerance`, for the level and for each row."""
        return self.excess <= tolerance * self.scale and self.shift <= tolerance


@dataclass(frozen=True, slots=True)
class Certificate:
    """The checks of all levels, and last of the least norm."""

    levels: tuple[LevelCertificate, ...]
    least_norm: LevelCertificate

    def holds(self, tolerance: float = 1e-7) -> bool:
        """Tell whether every excess is below `tolerance` times the size of its level, every shift
        below `tolerance`."""
        return all(c.holds(tolerance) for c in (*self.levels, self.least_norm))

    def __str__(self) -> str:
        named = [(f"level {i}", c) for i, c in enumerate(self.levels)]
        named.append(("least norm", self.least_norm))
        return "\n".join(
            f"{name:<10}  |w| = {c.slack:.3e}, at most {c.excess:.1e} above the optimum, "
            f"stationary to {c.residual:.1e}, bounds shifted by {c.shift:.1e}"
            for name, c in named
        )


def certify(hierarchy: Hierarchy, v: np.ndarray, tolerance: float = 1e-8) -> Certificate:
    """Check v [n] against the optimality conditions of every level.

    `tolerance`, relative to the size of a row's value: how near a bound is at the bound.
    """
    n, ends = hierarchy.n, hierarchy.ends
    if not np.isfinite(v).all():
        lost = [_lost(np.full(e, np.inf)) for e in ends]
        return Certificate(tuple(lost), _lost(np.full(len(hierarchy.lower), np.inf)))
    rows = _RowsAt.of(hierarchy, v, tolerance)
    reach = REACH * float(np.linalg.norm(v))
    levels = [
        _check(rows.part(hierarchy.level(i)), rows.part(slice(0, hierarchy.level(i).start)), reach)
        for i in range(len(ends))
    ]
    zero = np.zeros(n)
    norm = _RowsAt.of(Hierarchy(np.eye(n), zero, zero, (n,), ()), v, tolerance)
    return Certificate(tuple(levels), _check(norm, rows, reach))


def _lost(multipliers: np.ndarray) -> LevelCertificate:
    return LevelCertificate(np.inf, np.inf, np.inf, 0.0, np.inf, multipliers)


@dataclass(frozen=True, slots=True)
class _RowsAt:
    """Rows evaluated at v: values, violations, and which multipliers they may carry.

    `size`, what a violation is compared with; `free` rows (equalities and violated ones) carry a
    multiplier of any sign, and those at `both` bounds; where `side` is 1 or -1, one of that sign.
    """

    A: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    norms: np.ndarray
    values: np.ndarray
    w: np.ndarray
    size: np.ndarray
    equal: np.ndarray
    free: np.ndarray
    both: np.ndarray
    side: np.ndarray

    @classmethod
    def of(cls, hierarchy: Hierarchy, v: np.ndarray, tolerance: float) -> _RowsAt:
        """Evaluate the rows of a hierarchy."""
        A, lower, upper = hierarchy.A, hierarchy.lower, hierarchy.upper
        norms, values = np.linalg.norm(A, axis=1), A @ v
        w = values - np.clip(values, lower, upper)
        size = np.maximum(norms * np.linalg.norm(v), np.abs(np.clip(0.0, lower, upper)))
        equal = lower == upper
        free = equal | (np.abs(w) > ROUNDING * size)
        margin = tolerance * size
        at_upper, at_lower = values >= upper - margin, values <= lower + margin
        both = at_upper & at_lower & ~free
        side = at_upper.astype(float) - at_lower
        side[free] = 0.0
        return cls(A, lower, upper, norms, values, w, size, equal, free, both, side)

    def part(self, rows: slice) -> _RowsAt:
        """Return some of the rows."""
        return _RowsAt(*(getattr(self, field.name)[rows] for field in fields(self)))


@dataclass(frozen=True, slots=True)
class _Pair:
    """Violations `mu` of the own rows and multipliers `lam` of those above, nearly in balance."""

    mu: np.ndarray
    lam: np.ndarray


def _check(own: _RowsAt, above: _RowsAt, reach: float) -> LevelCertificate:
    """Check a level with the best of the pairs: none, without and with own rows at a bound.

    None is the right one where all rows that can be met are met.
    """
    slack, scale = float(np.linalg.norm(own.w)), float(np.linalg.norm(own.size))
    of_zeros = np.where(own.norms > 0.0, 0.0, own.w)  # a row of zeros is in balance by itself
    nothing = _Pair(of_zeros, np.zeros(len(above.w)))
    if not slack > 0.0:
        return LevelCertificate(0.0, 0.0, 0.0, scale, 0.0, nothing.lam)
    best = _judge(own, above, nothing, reach)
    for at_bound in (False, True):
        if at_bound and not (own.side.any() or own.both.any()):
            continue
        for pair in _pairs(own, above, at_bound):
            found = _judge(own, above, pair, reach)
            if _key(found) < _key(best):
                best = found
    return best


def _key(found: LevelCertificate) -> float:
    return max(found.excess / found.scale if found.scale > 0.0 else found.excess, found.shift)


def _pairs(own: _RowsAt, above: _RowsAt, at_bound: bool) -> tuple[_Pair, _Pair]:
    """Return violations and multipliers of the right signs that balance each other best.

    The first: multipliers for the violations as they are, `at_bound` also of own rows at a bound.
    The second: both changed a little, the violations in proportion to the size of their rows.
    Where rows are nearly dependent that little may be too much, and the first is the better one.
    """
    split = len(own.w)
    A, norms = np.vstack([own.A, above.A]), np.concatenate([own.norms, above.norms])
    norms = np.where(norms > 0.0, norms, 1.0)
    unit = A / norms[:, None]
    fixed = np.concatenate([own.free, np.zeros(len(above.w), dtype=bool)])
    free = np.concatenate([own.both & at_bound, above.free | above.both])
    sides = np.concatenate([own.side * at_bound, above.side])
    forces = np.zeros(len(norms))
    forces[:split] = np.where(own.free, own.w * own.norms, 0.0)
    forces += _best_multipliers(unit, unit.T @ forces, free, sides)
    wanted, first = forces.copy(), _pair_of(own, forces, norms)
    cheap = CHEAP * float(np.max(own.size * own.norms, initial=0.0))
    weights = np.concatenate([own.size * own.norms, np.full(len(above.w), cheap)])
    weights[~(fixed | free | (forces != 0.0))] = 0.0
    forces += _carried(unit, weights, -(unit.T @ forces))
    one_sided = np.concatenate([~own.equal & ~own.both, ~above.free & ~above.both])
    forces[one_sided & (forces * wanted < 0.0)] = 0.0
    return first, _pair_of(own, forces, norms)


def _pair_of(own: _RowsAt, forces: np.ndarray, norms: np.ndarray) -> _Pair:
    """Return the pair of forces along unit rows; a row of zeros keeps its violation."""
    split = len(own.w)
    mu = np.where(own.norms > 0.0, forces[:split] / norms[:split], own.w)
    return _Pair(mu, forces[split:] / norms[split:])


def _best_multipliers(
    unit: np.ndarray, gradient: np.ndarray, free: np.ndarray, sides: np.ndarray
) -> np.ndarray:
    """Return the forces [rows] of free rows and of the right sides that balance a gradient best."""
    signed = sides != 0.0
    onto_free = _row_space(unit[free])
    outside = -(gradient - onto_free @ (onto_free.T @ gradient))
    cone = (unit[signed] * sides[signed, None]).T
    cone = cone - onto_free @ (onto_free.T @ cone)
    cone[:, np.linalg.norm(cone, axis=0) <= RANK_TOLERANCE] = 0.0  # rounding would be magnified
    forces = np.zeros(len(unit))
    forces[signed] = _non_negative(cone, outside) * sides[signed]
    rest = -(gradient + unit[signed].T @ forces[signed])
    forces[free] = _least_squares(unit[free].T, rest)
    return forces


def _carried(unit: np.ndarray, weights: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Return forces [rows] along unit rows that add up to a target [n], or nearly.

    As few rows as span the target carry it, those first that have most weight.
    """
    rest, basis = unit.copy(), np.empty((0, unit.shape[1]))
    chosen: list[int] = []
    while len(chosen) < min(unit.shape):
        left = np.linalg.norm(rest, axis=1)
        left[left <= NEARLY_DEPENDENT] = 0.0
        row = int(np.argmax(left * weights))
        if left[row] * weights[row] == 0.0:
            break
        along = rest[row] / left[row]
        along -= basis.T @ (basis @ along)  # what rounding has left of the others
        along /= np.linalg.norm(along)
        rest -= np.outer(rest @ along, along)
        rest[row] = 0.0
        basis = np.vstack([basis, along])
        chosen.append(row)
    forces = np.zeros(len(unit))
    forces[chosen] = _least_squares(unit[chosen].T, target)
    return forces


def _non_negative(columns: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Return x >= 0 that brings `columns` [n, k] x nearest to `target` [n]."""
    if not columns.size or not target.any():
        return np.zeros(columns.shape[1])
    require_package("scipy", "scipy", "a certificate")
    from scipy.optimize import lsq_linear, nnls

    size = float(np.linalg.norm(target))
    try:
        return nnls(columns, target / size)[0] * size
    except RuntimeError:  # its iteration limit
        return lsq_linear(columns, target / size, (0.0, np.inf), method="bvls").x * size


def _judge(own: _RowsAt, above: _RowsAt, pair: _Pair, reach: float) -> LevelCertificate:
    """Return what a pair tells: the shift of the own rows, and a bound on |w| - |w*|.

    |w*|^2 / 2 >= -|mu|^2 / 2 + mu . A v - support(mu) + lam . A' v - support'(lam) if the pair is
    in balance. What is not, r, counts with |r| times how far the optimum may be.
    """
    mu, lam = pair.mu, pair.lam
    slack, scale = float(np.linalg.norm(own.w)), float(np.linalg.norm(own.size))
    left = float(np.linalg.norm(own.A.T @ mu + above.A.T @ lam))
    of_rows = float(np.linalg.norm(own.A)) * scale
    residual = left / of_rows if of_rows > 0.0 else 0.0
    forces = float(np.abs(mu) @ own.norms + np.abs(lam) @ above.norms)
    rounding = PRECISION * forces / np.where(own.norms > 0.0, own.norms, np.inf)
    moved = np.maximum(np.abs(mu - own.w) - rounding, 0.0)
    shift = float(np.max(moved / np.maximum(own.size, SMALLEST), initial=0.0))
    if left > BALANCE_TOLERANCE * forces:
        return LevelCertificate(slack, residual, slack, scale, np.inf, lam)
    held_lower = np.where(above.free, above.values, np.minimum(above.lower, above.values))
    held_upper = np.where(above.free, above.values, np.maximum(above.upper, above.values))
    gap = 0.5 * float(own.w @ own.w) + 0.5 * float(mu @ mu)
    gap -= _complementary(mu, own.values, own.lower, own.upper)
    gap -= _complementary(lam, above.values, held_lower, held_upper)
    norm = float(np.linalg.norm(own.A))
    gap += left * max(reach, REACH * slack / norm if norm > 0.0 else 0.0)
    if not np.isfinite(gap):
        return LevelCertificate(slack, residual, slack, scale, np.inf, lam)
    best = max(slack**2 - 2.0 * max(gap, 0.0), 0.0)
    return LevelCertificate(slack, residual, slack - best**0.5, scale, shift, lam)


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


def _least_squares(columns: np.ndarray, target: np.ndarray) -> np.ndarray:
    if not columns.size:
        return np.zeros(columns.shape[1])
    return np.linalg.lstsq(columns, target, rcond=RANK_TOLERANCE)[0]
