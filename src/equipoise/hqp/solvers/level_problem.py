"""One level of the cascade: least squares of violations under hard rows, by a primal active set.

The unknown is y, with v = v_start + basis y, and y = 0 meets every hard row. A working set W of
hard rows is held at its bounds; a set S of rows of the level (equalities, and those beyond a bound)
is squared. Each step solves the equality problem of (W, S) by SVD, goes there or to the first row
it meets, and then lets rows with a multiplier of the wrong sign go.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from equipoise.hqp.solvers.row_least_squares import ROUNDING, solve_rows

STALLS_BEFORE_BLAND = 20
DEPENDENT = 1e-8  # a row of which less than this share is left depends on the others
VIOLATED = 1e-11  # of the same: a violation below it counts as none
RATE_FLOOR = 1e-12
SMALLEST = 1e-150


@dataclass(frozen=True, slots=True)
class HardRows:
    """Satisfied rows of solved levels, scaled to norm one: `lower <= A v <= upper`."""

    A: np.ndarray
    lower: np.ndarray
    upper: np.ndarray

    @classmethod
    def none(cls, n: int) -> HardRows:
        """Return no rows."""
        return cls(np.empty((0, n)), np.empty(0), np.empty(0))

    def where(self, keep: np.ndarray) -> HardRows:
        """Return the rows where `keep` [m] is true."""
        return HardRows(self.A[keep], self.lower[keep], self.upper[keep])

    def and_rows(self, A: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> HardRows:
        """Return these rows and more; the new ones are scaled to norm one."""
        norms = np.linalg.norm(A, axis=1)
        some = norms > 0.0
        norms = norms[some]
        return HardRows(
            np.vstack([self.A, A[some] / norms[:, None]]),
            np.concatenate([self.lower, lower[some] / norms]),
            np.concatenate([self.upper, upper[some] / norms]),
        )


@dataclass(frozen=True, slots=True)
class LevelProblem:
    """The rows of one level, the hard rows, and the point and basis to start from."""

    A: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    hard: HardRows
    v: np.ndarray
    basis: np.ndarray


@dataclass(frozen=True, slots=True)
class LevelResult:
    """The optimum of a level, the directions that it leaves free and the rows it hands down."""

    v: np.ndarray
    basis: np.ndarray
    hard: HardRows
    iterations: int
    converged: bool


def solve_level(problem: LevelProblem, iteration_limit: int) -> LevelResult:
    """Minimise the violation of a level over the free directions, under the hard rows."""
    search = _Search(problem)
    converged = search.run(iteration_limit)
    return search.finish(converged)


class _Search:
    """The state of the active-set search on one level."""

    def __init__(self, problem: LevelProblem) -> None:
        self.p = problem
        self.norms = np.linalg.norm(problem.A, axis=1)
        self.M = problem.A @ problem.basis
        self.M[np.linalg.norm(self.M, axis=1) <= DEPENDENT * self.norms] = 0.0
        self.G = problem.hard.A @ problem.basis
        self.G[np.linalg.norm(self.G, axis=1) <= DEPENDENT] = 0.0
        self.v = problem.v
        self.equal = problem.lower == problem.upper
        self.soft = self._violated_sides()
        self.work = np.zeros(len(self.G), dtype=np.int8)
        self.multipliers, self.noise = np.zeros(len(self.G)), np.zeros(len(self.G))
        self.w, self.rounding = np.zeros(len(self.norms)), np.zeros(len(self.norms))
        self.iterations = 0

    # -- the search -----------------------------------------------------------------------------

    def run(self, iteration_limit: int) -> bool:
        """Search until no row wants to change; tell whether that came before the limit."""
        stalls = 0
        while self.iterations < iteration_limit:
            self.iterations += 1
            step, row, side = self._move()
            stalls = stalls + 1 if step == 0.0 else 0
            if row is not None:
                self._hold(row, side)
                continue
            self.multipliers, self.noise = self._multipliers()
            if not self._let_go(bland=stalls > STALLS_BEFORE_BLAND):
                return True
        return False

    def _move(self) -> tuple[float, int | None, int]:
        """Go toward the optimum of (W, S); return the length gone and the row that stopped it."""
        toward = self._direction()
        along = self.p.basis @ toward
        hard, soft = self.p.hard, self.p
        floor = RATE_FLOOR * float(np.linalg.norm(toward))
        stops = [
            _ratios(hard.A @ self.v, self.G @ toward, hard.lower, hard.upper, floor),
            _ratios(soft.A @ self.v, self.M @ toward, soft.lower, soft.upper, floor * self.norms),
        ]
        reach, sides = (np.concatenate(parts) for parts in zip(*stops, strict=True))
        reach[np.concatenate([self.work, self.soft]) != 0] = np.inf
        row = int(np.argmin(reach)) if len(reach) else -1
        if row < 0 or reach[row] >= 1.0:
            self.v = self.v + along
            return float(np.linalg.norm(along)), None, 0
        length = max(float(reach[row]), 0.0)
        self.v = self.v + length * along
        return length * float(np.linalg.norm(along)), row, int(sides[row])

    def _direction(self) -> np.ndarray:
        """Return the least y that reaches the optimum of the equality problem of (W, S).

        Keeps the violations there, zero where all are met, and how far they are rounding.
        """
        held = _null_space(self.G[self.work != 0], DEPENDENT)
        S = self.soft != 0
        M = self.M[S] @ held
        M[np.linalg.norm(M, axis=1) <= DEPENDENT * self.norms[S]] = 0.0
        y, self.w[S], self.rounding[S] = solve_rows(M, -self._beyond()[S], self.norms[S], self.size)
        self.w[~S] = self.rounding[~S] = 0.0
        return held @ y

    def _beyond(self) -> np.ndarray:
        """Return `A v - bound` [m] for the rows in S, the bound being the side they are held to."""
        bound = np.where(self.soft > 0, self.p.upper, self.p.lower)
        return np.where(self.soft != 0, self.p.A @ self.v - np.where(self.soft, bound, 0.0), 0.0)

    def _multipliers(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the multipliers [h] of W, M^T w + G^T multipliers = 0, and their rounding."""
        W = self.work != 0
        multipliers, noise = np.zeros(len(self.G)), np.zeros(len(self.G))
        if W.any():
            inverse = np.linalg.pinv(self.G[W].T, rcond=DEPENDENT)
            multipliers[W] = -inverse @ (self.M.T @ self.w)
            rounding = self.rounding + ROUNDING * np.abs(self.w)
            noise[W] = np.linalg.norm(inverse, axis=1) * float(self.norms @ rounding)
        return multipliers, noise

    def _hold(self, row: int, side: int) -> None:
        if row < len(self.work):
            self.work[row] = side
        else:
            self.soft[row - len(self.work)] = side

    def _release(self, row: int) -> None:
        index = row - len(self.work)
        self._hold(row, 0 if index < 0 else int(self._violated_sides()[index]))

    def _let_go(self, bland: bool) -> bool:
        """Take rows with a wrong sign out of S and W; tell whether there were any."""
        wrong_soft = ~self.equal & (-self.w * self.soft > self.rounding)
        push = -self.multipliers * self.work
        wrong_hard = push > self.noise
        if bland:
            first = np.flatnonzero(np.concatenate([wrong_hard, wrong_soft]))[:1]
            for row in first:
                self._release(int(row))
            return len(first) > 0
        if wrong_soft.any():
            self.soft[wrong_soft] = self._violated_sides()[wrong_soft]
            return True
        if wrong_hard.any():
            self.work[int(np.argmax(push))] = 0
            return True
        return False

    # -- what counts as zero --------------------------------------------------------------------

    @property
    def size(self) -> float:
        """The size of v."""
        return max(float(np.linalg.norm(self.v)), SMALLEST)

    def _violated_sides(self) -> np.ndarray:
        values = self.p.A @ self.v
        sides = (values > self.p.upper).astype(np.int8) - (values < self.p.lower)
        sides[self.equal] = 1
        return sides

    # -- the end --------------------------------------------------------------------------------

    def finish(self, converged: bool) -> LevelResult:
        """Fix what the optimum fixes, and hand the other rows down as hard rows."""
        p, floor = self.p, VIOLATED * self.norms * self.size
        fixed_soft = self.equal | (np.abs(self.w) > np.maximum(self.rounding, floor))
        fixed_hard = np.abs(self.multipliers) > self.noise
        scaled = self.M[fixed_soft] / np.maximum(self.norms[fixed_soft], 1e-300)[:, None]
        directions = _null_space(np.vstack([self.G[fixed_hard], scaled]), DEPENDENT)
        bounded = ~fixed_soft & (np.isfinite(p.lower) | np.isfinite(p.upper))
        hard = p.hard.where(~fixed_hard)
        hard = hard.and_rows(p.A[bounded], p.lower[bounded], p.upper[bounded])
        return LevelResult(self.v, p.basis @ directions, hard, self.iterations, converged)


def _ratios(
    values: np.ndarray,
    rates: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    floor: np.ndarray | float,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the step [m] at which each row meets a bound (inf: never) and the side it meets."""
    moving = np.abs(rates) > floor
    sides = np.sign(rates).astype(np.int8)
    reach = np.full(len(values), np.inf)
    bound = np.where(sides > 0, upper, lower)[moving]
    reach[moving] = (bound - values[moving]) / rates[moving]
    return reach, sides


def _null_space(rows: np.ndarray, tolerance: float) -> np.ndarray:
    """Return an orthonormal basis [k, d] of the directions that unit rows [m, k] leave alone."""
    k = rows.shape[1]
    if not rows.size:
        return np.eye(k)
    _, s, right = np.linalg.svd(rows)
    return right[int((s > tolerance).sum()) :].T
