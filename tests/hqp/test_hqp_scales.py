"""Rows of very different length, bounds of any size, numbers that are none: exact, or said so."""

from __future__ import annotations

import numpy as np
import pytest
from hqp_problems import block, equalities, random_hierarchy

from equipoise.errors import InputError
from equipoise.hqp import Hierarchy, Status, certify, make_solver
from equipoise.hqp.solvers.active_set.solver import ActiveSet

EXACT = ("active_set", "cascade")
INF = np.inf


@pytest.mark.parametrize("name", EXACT)
@pytest.mark.parametrize("length", [1.0, 1e-2, 1e-4, 1e-6, 1e-7])
@pytest.mark.parametrize("bound", [0.5, 0.99, 0.999999])
def test_a_short_row_beside_a_long_one_is_met_to_its_own_size(name, length, bound) -> None:
    """length x = length and x >= bound: x = 1 meets both, x = bound meets one."""
    A, lower, upper = np.array([[length], [1.0]]), [length, bound], [length, INF]
    h = Hierarchy.stack([[block("a", A, np.array(lower), np.array(upper))]], 1)
    answer = make_solver(name).solve(h)
    assert answer.solved
    assert answer.v == pytest.approx([1.0], rel=1e-9)
    assert certify(h, answer.v).holds(1e-9)
    assert not certify(h, np.array([bound])).holds(1e-7)


@pytest.mark.parametrize("name", EXACT)
@pytest.mark.parametrize("seed", range(6))
def test_lengths_apart_inside_a_level_change_nothing_that_can_be_met(name, seed) -> None:
    """Scaling a row and its bounds by 1e-4 to 1e4 moves no optimum of levels that can be met."""
    h = random_hierarchy("feasible", 900 + seed)
    scale = 10.0 ** np.random.default_rng(seed).choice([-4.0, -2.0, 0.0], len(h.lower))
    scaled = Hierarchy(h.A * scale[:, None], h.lower * scale, h.upper * scale, h.ends, h.blocks)
    answer, plain = make_solver(name).solve(scaled), make_solver(name).solve(h)
    assert answer.solved
    missed = np.maximum(h.lower - h.A @ answer.v, h.A @ answer.v - h.upper)  # in the row's own size
    assert missed.max() < 1e-6 * np.linalg.norm(h.A, axis=1).max()
    assert answer.v == pytest.approx(plain.v, abs=1e-6)


def test_a_row_too_short_to_leave_a_digit_is_refused_by_name() -> None:
    A = np.array([[1e-9, 0.0], [1.0, 1.0]])
    with pytest.raises(InputError, match=r"'a0'.*times shorter than"):
        Hierarchy.stack([[equalities("a", A, np.array([1e-9, 0.5]))]], 2)


@pytest.mark.parametrize("size", [1e2, 1e8, 1e15, 1e20, 1e26, 1e30])
@pytest.mark.parametrize("far", ["lower", "upper", "equal", "both"])
def test_a_warm_start_after_a_huge_bound_answers_as_a_cold_one(size, far) -> None:
    rng = np.random.default_rng(0)
    A, narrow = rng.normal(size=(2, 3)), (-0.2, -0.1)
    wide = {
        "lower": (size, 2 * size), "upper": (-2 * size, -size), "equal": (size, size),
        "both": (-size, size),
    }[far]  # fmt: skip

    def problem(first: tuple[float, float]) -> Hierarchy:
        lower, upper = np.array([first[0], narrow[0]]), np.array([first[1], narrow[1]])
        return Hierarchy.stack([[block("a", A, lower, upper)]], 3)

    warm = ActiveSet()
    warm.solve(problem(wide))
    usual = problem((-1.0, 1.0))
    answer, cold = warm.solve(usual), ActiveSet().solve(usual)
    assert answer.solved
    assert answer.v == pytest.approx(cold.v, abs=1e-12)
    assert certify(usual, answer.v).holds(1e-9)


@pytest.mark.parametrize("name", EXACT)
def test_a_row_of_zeros_that_cannot_be_met_is_certified_and_no_excuse(name) -> None:
    first = equalities("a", np.array([[0.0, 0.0], [1.0, 0.0]]), np.array([1.0, 2.0]))
    second = equalities("b", np.array([[1.0, 1.0]]), np.array([0.0]))
    h = Hierarchy.stack([[first], [second]], 2)
    answer = make_solver(name).solve(h)
    assert answer.v == pytest.approx([2.0, -2.0], abs=1e-12)
    assert answer.slack == pytest.approx((1.0, 0.0), abs=1e-12)
    assert certify(h, answer.v).holds(1e-9)
    for wrong in ([2.0, -2.001], [2.001, -2.001], [0.0, 0.0]):
        assert not certify(h, np.array(wrong)).holds(1e-7)


@pytest.mark.parametrize("poison", [np.nan, INF, -INF])
@pytest.mark.parametrize("where", ["A", "lower", "upper", "both"])
def test_numbers_that_are_none_end_as_a_status_and_leave_nothing_behind(poison, where) -> None:
    """What comes past the checks, from a kernel task say, must not loop or be remembered."""
    solver, rng = ActiveSet(), np.random.default_rng(5)
    for seed in range(12):
        h = random_hierarchy("infeasible", 40 + seed)
        A, lower, upper = h.A.copy(), h.lower.copy(), h.upper.copy()
        row = int(rng.integers(len(lower)))
        if where == "A":
            A[row, rng.integers(A.shape[1])] = poison
        if where in ("lower", "both"):
            lower[row] = poison
        if where in ("upper", "both"):
            upper[row] = poison
        answer = solver.solve(Hierarchy(A, lower, upper, h.ends, h.blocks))
        assert answer.status in Status
        assert np.isfinite(answer.v).all()
        again = solver.solve(h)
        assert certify(h, again.v).holds(1e-9)
