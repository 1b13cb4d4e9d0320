"""The convex hull in a plane against Qhull's, and in space by Coal against scipy's."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from equipoise.spatial import convex_hull
from equipoise.spatial.solid_hull import hull_by_coal, solid_hull


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


def volume_of(points, triangles):
    """Return the volume that triangles enclose, seen from outside anticlockwise."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0


@settings(max_examples=50, deadline=None)
@given(st.integers(4, 60), st.floats(1e-3, 1e3), st.integers(0, 2**32 - 1))
def test_in_space_coal_finds_what_scipy_finds(count, size, seed):
    points = size * np.random.default_rng(seed).normal(size=(count, 3))
    theirs, ours = solid_hull(points, "Qt"), hull_by_coal(points)
    assert set(ours.corners) == set(theirs.corners)
    assert ours.volume == pytest.approx(theirs.volume, rel=1e-9)
    for hull in (theirs, ours):
        assert volume_of(points, hull.triangles) == pytest.approx(theirs.volume, rel=1e-9)


def test_in_space_a_box_with_points_on_its_faces_and_edges_keeps_its_volume():
    ends = np.array([[x, y, z] for x in (0, 1.0) for y in (0, 2.0) for z in (0, 3.0)])
    others = np.array([[0.5, 0.0, 0.0], [0.5, 1.0, 0.0], [1.0, 2.0, 3.0], [0.3, 0.4, 0.5]])
    ours = hull_by_coal(np.vstack((ends, others)))
    assert ours.volume == pytest.approx(6.0)
    assert set(range(8)) >= set(ours.corners) - {10, 8, 9}


@pytest.mark.parametrize("points", [np.zeros((3, 3)), np.ones((9, 3)), np.eye(3)[[0, 1, 2, 0]]])
def test_in_space_flat_points_have_no_hull(points):
    assert hull_by_coal(points) is None
