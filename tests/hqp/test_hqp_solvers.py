"""The solvers against each other, against the certificate and against SciPy."""

from __future__ import annotations

import numpy as np
import pytest
from hqp_problems import KINDS, block, equalities, random_hierarchy
from scipy.optimize import minimize

from equipoise.errors import InputError, NameNotFoundError
from equipoise.hqp import SOLVERS, Hierarchy, Status, certify, make_solver, violation
from equipoise.hqp.solvers.active_set.solver import ActiveSet
from equipoise.hqp.solvers.cascade import Cascade
from equipoise.hqp.solvers.level_problem import _Search
from equipoise.hqp.solvers.recursion import Recursion

EXACT = ("active_set", "cascade")
BOUNDED = ("active_set", "cascade", "daqp")


def lexicographic_by_slsqp(h: Hierarchy) -> list[float]:
    """Return the slack of each level by SciPy's SLSQP, level by level; for small problems."""
    v, held, slack = np.zeros(h.n), [], []
    for i in range(len(h.ends)):
        rows = h.level(i)
        A, lower, upper = h.A[rows], h.lower[rows], h.upper[rows]

        def cost(v, A=A, lower=lower, upper=upper):
            w = A @ v - np.clip(A @ v, lower, upper)
            return 0.5 * w @ w, A.T @ w

        found = minimize(
            cost, v, jac=True, constraints=held, method="SLSQP", options={"ftol": 1e-15}
        )
        v = found.x
        w = A @ v - np.clip(A @ v, lower, upper)
        slack.append(float(np.linalg.norm(w)))
        for a, low, high, r in zip(A, lower, upper, w, strict=True):
            if np.isfinite(high):
                held.append(_at_most(a, high + max(r, 0.0)))
            if np.isfinite(low):
                held.append(_at_most(-a, -(low + min(r, 0.0))))
    return slack


def _at_most(a: np.ndarray, bound: float) -> dict:
    return {"type": "ineq", "fun": lambda v: bound - a @ v, "jac": lambda v: -a}


@pytest.mark.parametrize("name", EXACT)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(12))
def test_exact_solvers_are_certified_on_every_kind(name, kind, seed) -> None:
    h = random_hierarchy(kind, seed)
    answer = make_solver(name).solve(h)
    assert answer.solved
    certificate = certify(h, answer.v)
    assert certificate.holds(1e-9), str(certificate)


@pytest.mark.parametrize("name", EXACT)
@pytest.mark.parametrize("kind", ["feasible", "infeasible", "boxes"])
@pytest.mark.parametrize("seed", range(4))
def test_exact_solvers_agree_with_slsqp(name, kind, seed) -> None:
    h = random_hierarchy(kind, 500 + seed, n=4)
    expected = lexicographic_by_slsqp(h)
    assert make_solver(name).solve(h).slack == pytest.approx(expected, abs=2e-5)


@pytest.mark.parametrize("seed", range(8))
def test_recursion_is_the_cascade_on_equalities(seed) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(5, 30))
    shared = rng.normal(size=(3, n))
    levels = [
        [equalities("a", shared, rng.normal(size=3))],
        [equalities("b", np.vstack([shared, rng.normal(size=(2, n))]), rng.normal(size=5))],
        [equalities("c", rng.normal(size=(n // 3, n)), rng.normal(size=n // 3))],
    ]
    h = Hierarchy.stack(levels, n)
    one, other = make_solver("recursion").solve(h), make_solver("cascade").solve(h)
    assert np.abs(one.v - other.v).max() < 1e-9 * np.linalg.norm(other.v)
    assert certify(h, one.v).holds(1e-10)


def test_recursion_refuses_inequalities_by_name() -> None:
    rows = block("knee limits", np.eye(3), -np.ones(3), np.ones(3))
    with pytest.raises(InputError, match=r"'knee limits' of level 0.*'cascade'"):
        make_solver("recursion").solve(Hierarchy.stack([[rows]], 3))


def test_damping_bounds_the_answer_near_a_singularity() -> None:
    A = np.diag([1.0, 1e-7])
    h = Hierarchy.stack([[equalities("hand", A, np.ones(2))]], 2)
    assert np.linalg.norm(Recursion().solve(h).v) > 1e6
    damped = Recursion(damping=0.05).solve(h)
    assert np.linalg.norm(damped.v) < 2.0
    assert damped.v[0] == pytest.approx(1.0, abs=1e-12)  # far from singular: untouched


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize(("kind", "unit"), [("feasible", False), ("infeasible", True)])
def test_daqp_agrees_where_levels_are_feasible_or_rows_are_unit(kind, unit, seed) -> None:
    h = random_hierarchy(kind, seed, unit_rows=unit)
    one, other = make_solver("daqp").solve(h), make_solver("cascade").solve(h)
    assert one.solved
    assert one.slack == pytest.approx(other.slack, abs=1e-6)


def test_daqp_minimises_normalised_rows_on_an_infeasible_level() -> None:
    """v = 0 by a row of norm 1 and v = 1 by a row of norm 3: (15) says 0.9, DAQP says 0.5."""
    A = np.array([[1.0], [3.0]])
    h = Hierarchy.stack([[equalities("pull", A, np.array([0.0, 3.0]))]], 1)
    exact, other = make_solver("cascade").solve(h), make_solver("daqp").solve(h)
    assert exact.v[0] == pytest.approx(0.9, abs=1e-12)
    assert other.v[0] == pytest.approx(0.5, abs=1e-6)
    assert other.slack[0] > 1.5 * exact.slack[0]
    assert not certify(h, other.v).holds(1e-3)


def test_daqp_gives_up_levels_below_dependent_equalities() -> None:
    """Rows of level 1 are sums and differences of level 0; level 2 can be met, and is not."""
    held = np.array([[1.0, 2.0, 3.0], [3.0, 1.0, 2.0]])
    again = np.array([held[0] + held[1], held[1] - held[0]])
    task = equalities("task", np.array([[1.0, 1.0, 0.0]]), np.ones(1))
    levels = [[equalities("held", held, np.zeros(2))], [equalities("again", again, np.zeros(2))]]
    h = Hierarchy.stack([*levels, [task]], 3)
    for name in EXACT:
        assert make_solver(name).solve(h).slack[2] < 1e-12
    answer = make_solver("daqp").solve(h)
    assert answer.solved
    assert answer.slack[2] == pytest.approx(1.0)
    assert not certify(h, answer.v).holds(1e-3)


@pytest.mark.parametrize("name", BOUNDED)
@pytest.mark.parametrize("seed", range(5))
def test_a_feasible_first_level_is_met(name, seed) -> None:
    h = random_hierarchy("feasible", 100 + seed)
    assert make_solver(name).solve(h).slack[0] < 1e-8 * np.linalg.norm(h.A)


@pytest.mark.parametrize("name", BOUNDED)
def test_empty_levels_free_rows_and_no_rows_are_fine(name) -> None:
    free = block("free", np.ones((1, 3)), np.array([-np.inf]), np.array([np.inf]))
    hand = equalities("hand", np.eye(3)[:1], np.array([2.0]))
    answer = make_solver(name).solve(Hierarchy.stack([[], [free], [], [hand]], 3))
    assert answer.solved
    assert answer.v == pytest.approx([2.0, 0.0, 0.0], abs=1e-8)
    assert answer.active.tolist() == [0, 2]
    assert make_solver(name).solve(Hierarchy.stack([], 3)).v.tolist() == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("name", EXACT)
def test_rows_of_zeros_move_nothing(name) -> None:
    """A row of zeros has a violation that nobody can change."""
    dead = equalities("dead", np.zeros((2, 3)), np.array([1.0, 0.0]))
    hand = equalities("hand", np.eye(3)[:1], np.array([2.0]))
    answer = make_solver(name).solve(Hierarchy.stack([[dead, hand]], 3))
    assert answer.v == pytest.approx([2.0, 0.0, 0.0], abs=1e-12)
    assert answer.slack == pytest.approx((1.0,), abs=1e-12)


@pytest.mark.parametrize("name", EXACT)
def test_a_lower_level_never_harms_a_higher_one(name) -> None:
    for seed in range(5):
        h = random_hierarchy("infeasible", 40 + seed)
        whole = make_solver(name).solve(h)
        for i in range(1, len(h.ends)):
            rows = h.ends[i - 1]
            blocks = h.blocks[:i]
            part = Hierarchy(h.A[:rows], h.lower[:rows], h.upper[:rows], h.ends[:i], blocks)
            alone = make_solver(name).solve(part)
            assert whole.slack[:i] == pytest.approx(alone.slack, rel=1e-9, abs=1e-9)


def test_the_answer_carries_its_own_residuals() -> None:
    h = random_hierarchy("infeasible", 7)
    answer = make_solver("cascade").solve(h)
    w = violation(h, answer.v)
    assert np.array_equal(answer.w, w)
    for i, slack in enumerate(answer.slack):
        assert slack == pytest.approx(np.linalg.norm(w[h.level(i)]))
    beyond = np.abs(w) > 1e-6
    equal = h.lower == h.upper
    assert (answer.active[equal] == 2).all()
    assert (answer.active[beyond & ~equal] == np.sign(w[beyond & ~equal])).all()


@pytest.mark.parametrize("solver", [ActiveSet, Cascade])
def test_an_iteration_limit_is_a_status_and_the_answer_is_finite(solver) -> None:
    h = random_hierarchy("boxes", 0)
    answer = solver(iteration_limit=1).solve(h)
    assert answer.status is Status.ITERATION_LIMIT
    assert np.isfinite(answer.v).all()


def test_a_cascade_that_never_lets_a_row_go_is_noticed(monkeypatch) -> None:
    monkeypatch.setattr(_Search, "_let_go", lambda self, bland: False)
    answers = [(h, make_solver("cascade").solve(h)) for h in _some()]
    assert not all(certify(h, answer.v).holds(1e-6) for h, answer in answers)


def test_a_cascade_with_a_flipped_multiplier_is_noticed(monkeypatch) -> None:
    honest = _Search._multipliers
    monkeypatch.setattr(_Search, "_multipliers", lambda self: (-honest(self)[0], honest(self)[1]))
    answers = [(h, make_solver("cascade").solve(h)) for h in _some()]
    assert not all(certify(h, answer.v).holds(1e-6) for h, answer in answers)


def _some() -> list[Hierarchy]:
    return [random_hierarchy("infeasible", seed, n=12) for seed in range(4)]


def test_an_unknown_solver_is_answered_with_the_known_ones() -> None:
    with pytest.raises(NameNotFoundError, match="cascade"):
        make_solver("cascad")
    assert set(SOLVERS) >= {"recursion", "cascade", "daqp"}
