"""The certificate says yes to the optimum and no to everything else."""

from __future__ import annotations

import numpy as np
import pytest
from hqp_problems import block, equalities, random_hierarchy

from equipoise.bench.problem import HANDS, make_problem
from equipoise.bench.unreachable_targets import throw_hands
from equipoise.hqp import Hierarchy, certificate, certify, make_solver
from equipoise.hqp.solution import violation
from equipoise.motion import MotionGenerator


@pytest.fixture(params=range(4))
def solved(request):
    h = random_hierarchy("infeasible", 60 + request.param, n=15)
    return h, make_solver("cascade").solve(h).v


def test_a_step_away_is_noticed(solved) -> None:
    h, v = solved
    assert certify(h, v).holds(1e-9)
    rng = np.random.default_rng(0)
    for _ in range(5):
        away = v + 1e-4 * np.linalg.norm(v) * rng.normal(size=len(v))
        assert not certify(h, away).holds(1e-7)


def test_multipliers_balance_the_violation_with_the_right_signs(solved) -> None:
    h, v = solved
    for i, level in enumerate(certify(h, v).levels):
        rows, above = h.level(i), slice(0, h.level(i).start)
        values = h.A @ v
        w = values - np.clip(values, h.lower, h.upper)
        pull = h.A[rows].T @ w[rows]
        assert np.abs(pull + h.A[above].T @ level.multipliers).max() <= 1e-9 * (
            1.0 + np.abs(pull).max()
        )
        satisfied = (np.abs(w[above]) < 1e-9) & (h.lower[above] < h.upper[above])
        inside = satisfied & (values[above] < h.upper[above] - 1e-6)
        assert (level.multipliers[inside] <= 0.0).all()
        inside = satisfied & (values[above] > h.lower[above] + 1e-6)
        assert (level.multipliers[inside] >= 0.0).all()


def test_a_multiplier_says_what_a_bound_costs() -> None:
    """d(|w|^2/2)/d(bound) of a blocking row is minus its multiplier: checked by differences."""
    task = equalities("task", np.array([[1.0, 1.0], [1.0, -2.0]]), np.array([3.0, 1.0]))

    def solve(bound: float):
        wall = block("wall", np.array([[2.0, 0.5]]), np.array([-np.inf]), np.array([bound]))
        h = Hierarchy.stack([[wall], [task]], 2)
        answer = make_solver("cascade").solve(h)
        return 0.5 * answer.slack[1] ** 2, certify(h, answer.v).levels[1].multipliers[0]

    cost, multiplier = solve(1.0)
    assert multiplier > 0.1
    slope = (solve(1.0 + 1e-6)[0] - solve(1.0 - 1e-6)[0]) / 2e-6
    assert slope == pytest.approx(-multiplier, rel=1e-6)
    assert cost > 0.0


def test_the_excess_bounds_the_true_one() -> None:
    rng = np.random.default_rng(5)
    for _ in range(10):
        rows = block("many", rng.normal(size=(14, 6)), np.full(14, -1.0), np.full(14, -0.9))
        h = Hierarchy.stack([[rows]], 6)
        best = make_solver("cascade").solve(h)
        level = certify(h, best.v + 1e-3 * rng.normal(size=6)).levels[0]
        true = level.slack - best.slack[0]
        assert true > 0.0
        assert level.excess >= true - 1e-13
        assert certify(h, best.v).levels[0].excess < 1e-12


def test_more_norm_than_needed_is_noticed() -> None:
    h = Hierarchy.stack([[equalities("one", np.array([[1.0, 0.0]]), np.array([1.0]))]], 2)
    assert certify(h, np.array([1.0, 0.0])).holds(1e-12)
    wasteful = certify(h, np.array([1.0, 0.01]))
    assert not wasteful.holds(1e-6)
    assert wasteful.levels[0].excess == 0.0


def test_a_higher_level_sacrificed_for_a_lower_one_is_noticed() -> None:
    first = equalities("first", np.array([[1.0]]), np.array([0.0]))
    second = equalities("second", np.array([[1.0]]), np.array([1.0]))
    h = Hierarchy.stack([[first], [second]], 1)
    assert certify(h, np.zeros(1)).holds(1e-12)
    assert not certify(h, np.full(1, 0.5)).holds(1e-3)


def test_what_is_undefined_is_infinite() -> None:
    h = random_hierarchy("feasible", 1)
    certificate = certify(h, np.full(h.n, np.nan))
    assert not certificate.holds(1e300)
    assert all(level.excess == np.inf for level in certificate.levels)
    assert "inf" in str(certificate)


def test_scale_does_not_matter() -> None:
    h = random_hierarchy("infeasible", 9)
    v = make_solver("cascade").solve(h).v * 1.001
    c = 2.0**20
    scaled = Hierarchy(h.A, h.lower * c, h.upper * c, h.ends, h.blocks)
    one, other = certify(h, v), certify(scaled, v * c)
    for a, b in zip(one.levels, other.levels, strict=True):
        assert a.residual == pytest.approx(b.residual, rel=1e-6, abs=1e-15)
        assert a.excess * c == pytest.approx(b.excess, rel=1e-6, abs=1e-9 * c)


def test_the_wrong_sign_of_a_multiplier_is_no_excuse() -> None:
    """At a lower bound the row can only push up; a v that would need it to pull is not optimal."""
    wall = block("wall", np.array([[1.0]]), np.array([0.0]), np.array([np.inf]))
    task = equalities("task", np.array([[1.0]]), np.array([1.0]))
    assert not certify(Hierarchy.stack([[wall], [task]], 1), np.zeros(1)).holds(1e-3)
    away = equalities("away", np.array([[1.0]]), np.array([-1.0]))
    assert certify(Hierarchy.stack([[wall], [away]], 1), np.zeros(1)).holds(1e-12)


@pytest.mark.parametrize("part", ["_best_multipliers", "_complementary"])
def test_a_flipped_sign_in_the_certificate_is_noticed(monkeypatch, part) -> None:
    solved = [random_hierarchy("infeasible", 60 + seed, n=15) for seed in range(4)]
    answers = [make_solver("cascade").solve(h).v for h in solved]
    honest = getattr(certificate, part)
    monkeypatch.setattr(certificate, part, lambda *given: -honest(*given))
    assert not all(certify(h, v).holds(1e-9) for h, v in zip(solved, answers, strict=True))


@pytest.mark.parametrize("size", [1e3, 1e6])
def test_what_a_nearly_dependent_row_could_still_gain_is_in_the_excess(size: float) -> None:
    """A row that the level above all but forbids can be met a little better, far away."""
    above = equalities("above", np.array([[1.0, 0.0, 0.0]]), np.zeros(1))
    own = equalities("own", np.array([[1.0, 1e-9, 0.0], [0.0, 0.0, 1.0]]), np.array([1.0, size]))
    h = Hierarchy.stack([[above], [own]], 3)
    here, better = np.array([0.0, 0.0, size]), np.array([0.0, 5.0 * size, size])
    gain = np.subtract(*(np.linalg.norm(violation(h, v)[1:]) for v in (here, better)))
    assert gain > 0.0
    assert gain <= certify(h, here).levels[1].excess < 1e-3 * size


def test_balancing_among_nearly_dependent_rows_is_not_made_worse() -> None:
    """Hands thrown out of reach: at some ticks joint limits leave 1e-8 to share between rows."""
    problem = make_problem("hrp2")
    levels, solver = throw_hands(problem, HANDS), make_solver("active_set")
    motion = MotionGenerator(problem.robot, levels, solver, problem.dt, problem.q_start)
    for k in range(1340):
        step = motion.step(k * problem.dt)
        if k > 1270:
            certificate = step.solution.certificate(step.hierarchy)
            assert all(level.excess <= 1e-6 * level.scale for level in certificate.levels), k
