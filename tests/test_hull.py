"""The convex hull in a plane against Qhull's."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from equipoise.spatial import convex_hull


@settings(max_examples=100, deadline=None)
@given(st.integers(3, 40), st.floats(1e-6, 1e6), st.integers(0, 2**32 - 1))
def test_corners_are_qhulls_and_run_anticlockwise(count, size, seed):
    rng = np.random.default_rng(seed)
    points = size * rng.normal(size=(count, 2))
    corners = convex_hull(points)
    theirs = ConvexHull(points).vertices.tolist()
    start = theirs.index(corners[0])
    assert corners.tolist() == theirs[start:] + theirs[:start]


def test_points_on_edges_inside_and_twice_are_no_corners():
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    others = np.array([[0.5, 0.0], [1.0, 0.3], [0.4, 0.6], [1.0, 1.0], [1e-16, 1e-16]])
    corners = convex_hull(np.vstack([others, square]))
    assert np.allclose(np.vstack([others, square])[corners], square, atol=1e-15)
    assert len(corners) == 4


@pytest.mark.parametrize("points", [np.zeros((0, 2)), np.zeros((1, 2)), np.ones((5, 2))])
def test_points_without_an_area_have_fewer_than_three_corners(points):
    assert len(convex_hull(points)) < 3
    line = np.column_stack([np.arange(5.0), 0.1 * np.arange(5.0)])
    assert len(convex_hull(line)) < 3
