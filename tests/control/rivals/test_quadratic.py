"""The small program: equalities, bounds, and the conditions of an optimum, checked from outside."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.optimize

from equipoise.control.rivals.quadratic import minimise

NO_BOUNDS = np.zeros((0, 8)), np.zeros(0), np.zeros(0)


def problem(rng, rows=6):
    """Return a program of eight unknowns that has a solution."""
    metric = np.eye(8) + 0.3 * rng.normal(size=(8, 8))
    E, A, inside = rng.normal(size=(3, 8)), rng.normal(size=(rows, 8)), rng.normal(size=8)
    return (
        metric,
        rng.normal(size=8) * 3.0,
        (E, E @ inside),
        (A, A @ inside - 0.3, A @ inside + 0.3),
    )


def test_without_bounds_it_is_the_saddle_point(rng):
    metric, goal, (E, e), _ = problem(rng)
    W = metric.T @ metric
    saddle = np.block([[W, E.T], [E, np.zeros((3, 3))]])
    expected = np.linalg.solve(saddle, np.concatenate((W @ goal, e)))[:8]
    found = minimise(metric, goal, (E, e), NO_BOUNDS)
    np.testing.assert_allclose(found.x, expected, atol=1e-10)
    assert found.solved
    assert not found.bounded


@pytest.mark.parametrize("seed", range(10))
def test_with_bounds_the_conditions_of_an_optimum_hold(seed):
    """The gradient is a sum of equalities and of the bounds met, each pushing inwards."""
    metric, goal, (E, e), (A, lower, upper) = problem(np.random.default_rng(seed))
    found = minimise(metric, goal, (E, e), (A, lower, upper))
    x = found.x
    assert found.solved
    np.testing.assert_allclose(E @ x, e, atol=1e-9)
    assert (A @ x >= lower - 1e-7).all()
    assert (A @ x <= upper + 1e-7).all()
    gradient = metric.T @ (metric @ (x - goal))
    pushes = [A[i] for i in np.flatnonzero(A @ x < lower + 1e-6)]
    pushes += [-A[i] for i in np.flatnonzero(A @ x > upper - 1e-6)]
    directions = np.vstack([E, -E, *pushes]).T
    assert scipy.optimize.nnls(directions, gradient)[1] < 1e-5 * np.linalg.norm(gradient)


def test_equalities_that_repeat_are_met(rng):
    metric, goal, (E, e), bounds = problem(rng)
    twice = np.vstack((E, E[:1] + E[1:2])), np.append(e, e[0] + e[1])
    one, other = minimise(metric, goal, (E, e), bounds), minimise(metric, goal, twice, bounds)
    np.testing.assert_allclose(one.x, other.x, atol=1e-7)


def test_what_cannot_be_met_is_told_and_yields_where_it_may():
    A = np.array([[1.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    lower, upper = np.array([-np.inf, 2.0, -1.0]), np.array([1.0, np.inf, 1.0])
    equal = np.zeros((0, 2)), np.zeros(0)
    soft = np.array([False, True, False])
    found = minimise(np.ones(2), np.array([0.0, 3.0]), equal, (A, lower, upper), soft)
    assert not found.solved
    np.testing.assert_allclose(found.x, [1.0, 1.0], atol=1e-4)
