"""What the active-set solver promises beyond its answer: memory, dry land, plain Python."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest
from hqp_problems import KINDS, block, equalities, random_hierarchy

from equipoise.hqp import Hierarchy, Status, certify, make_solver
from equipoise.hqp.solvers.active_set.solver import ActiveSet


def shifted(h: Hierarchy, amount: float, seed: int) -> Hierarchy:
    """Return a problem with bounds and coefficients a little away."""
    rng = np.random.default_rng(seed)
    by = amount * rng.normal(size=len(h.lower))
    A = h.A + amount * rng.normal(size=h.A.shape) * (h.A != 0.0)
    return Hierarchy(A, h.lower + by, h.upper + by, h.ends, h.blocks)


@pytest.mark.parametrize("kind", KINDS)
def test_a_warm_start_changes_the_work_and_not_the_answer(kind) -> None:
    h = random_hierarchy(kind, 21)
    solver = ActiveSet()
    cold = solver.solve(h)
    again = solver.solve(h)
    assert again.iterations <= cold.iterations
    assert again.v == pytest.approx(cold.v, abs=1e-9 * (1.0 + np.linalg.norm(cold.v)))
    solver.reset()
    assert solver.solve(h).iterations == cold.iterations


@pytest.mark.parametrize("kind", ["infeasible", "redundant", "boxes"])
def test_a_run_of_problems_is_certified_all_along(kind) -> None:
    solver = ActiveSet()
    for seed in range(3):
        h = random_hierarchy(kind, 300 + seed, n=18)
        for tick in range(12):
            problem = shifted(h, 0.02 * tick, tick)
            answer = solver.solve(problem)
            assert answer.solved
            assert certify(problem, answer.v).holds(1e-9)


def test_another_shape_or_other_levels_need_no_reset() -> None:
    solver = ActiveSet()
    for seed in range(8):
        h = random_hierarchy("infeasible", 700 + seed)
        assert certify(h, solver.solve(h).v).holds(1e-9)
    whole = random_hierarchy("boxes", 5)
    merged = Hierarchy(whole.A, whole.lower, whole.upper, (len(whole.lower),), whole.blocks)
    for h in (whole, merged, whole):
        assert certify(h, solver.solve(h).v).holds(1e-9)


@pytest.mark.parametrize("scale", [1e-200, 1e-12, 1e12, 1e200])
def test_extreme_numbers_end_as_a_status_and_a_finite_answer(scale) -> None:
    h = random_hierarchy("infeasible", 4)
    extreme = Hierarchy(h.A * scale, h.lower * scale, h.upper * scale, h.ends, h.blocks)
    solver = ActiveSet()
    answer = solver.solve(extreme)
    assert np.isfinite(answer.v).all()
    assert answer.status in Status
    assert certify(h, solver.solve(h).v).holds(1e-9)  # and nothing of it stays behind


def test_any_layout_of_the_arrays_is_taken() -> None:
    from equipoise.hqp.solvers.active_set.solver import answer

    h = random_hierarchy("boxes", 8)
    A, lower = np.asfortranarray(h.A), h.lower.copy()
    lower.flags.writeable = False
    expected = ActiveSet().solve(h).v
    compiled = len(getattr(answer, "signatures", ()))
    odd = ActiveSet().solve(Hierarchy(A, lower, h.upper, h.ends, h.blocks))
    assert np.array_equal(odd.v, expected)
    assert len(getattr(answer, "signatures", ())) == compiled


def test_posture_in_any_order_of_rows_is_the_same_problem() -> None:
    """A level of unit rows takes a short way; in a scaled and shuffled form it must agree."""
    rng = np.random.default_rng(3)
    n = 9
    hand = equalities("hand", rng.normal(size=(4, n)), rng.normal(size=4))
    wall = block("wall", rng.normal(size=(5, n)), np.full(5, -0.2), np.full(5, 0.1))
    goal = rng.normal(size=n)
    order = rng.permutation(n)
    tidy = equalities("posture", np.eye(n), goal)
    mixed = equalities("posture", 3.0 * np.eye(n)[order], 3.0 * goal[order])
    turn = np.linalg.qr(rng.normal(size=(n, n)))[0]
    dense = equalities("posture", turn, turn @ goal)
    answers = [
        ActiveSet().solve(Hierarchy.stack([[hand], [wall], [posture]], n)).v
        for posture in (tidy, mixed, dense)
    ]
    assert answers[1] == pytest.approx(answers[0], abs=1e-12)
    assert answers[2] == pytest.approx(answers[0], abs=1e-10)


PLAIN = """
import sys
sys.path[:0] = sys.argv[1:]
import numpy as np
from hqp_problems import KINDS, random_hierarchy
from equipoise.hqp import make_solver
for kind in KINDS:
    h = random_hierarchy(kind, 11, n=7)
    print(" ".join(repr(float(x)) for x in make_solver("active_set").solve(h).v))
"""


def test_plain_python_gives_the_compiled_answer() -> None:
    here = os.path.dirname(__file__)
    run = subprocess.run(
        [sys.executable, "-c", PLAIN, here, *sys.path],
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
        check=True,
    )
    for kind, line in zip(KINDS, run.stdout.splitlines(), strict=True):
        h = random_hierarchy(kind, 11, n=7)
        plain = np.array([float(x) for x in line.split()])
        assert make_solver("active_set").solve(h).v == pytest.approx(plain, rel=1e-9, abs=1e-9)
