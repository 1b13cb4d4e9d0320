"""The support polygon against the corners it was made of."""

from __future__ import annotations

import numpy as np
import pytest

from equipoise.contacts import SupportPolygon
from equipoise.contacts.support_polygon import sole_corners
from equipoise.errors import InputError
from helpers import sole_contacts


def polygon_of(robot):
    contacts = sole_contacts(robot, robot.q_half_sitting)
    corners = np.vstack([sole_corners(c.sole, c.T_world_anchor) for c in contacts])
    return SupportPolygon.of_points(corners), corners


def test_every_corner_is_on_or_inside(hrp2):
    polygon, corners = polygon_of(hrp2)
    slack = polygon.offsets - corners[:, :2] @ polygon.normals.T
    assert slack.min() > -1e-12
    assert np.allclose(np.linalg.norm(polygon.normals, axis=1), 1.0)


def test_convex_combinations_are_inside_and_others_not(hrp2, rng):
    polygon, corners = polygon_of(hrp2)
    inside = rng.dirichlet(np.ones(len(corners)), size=100) @ corners[:, :2]
    assert min(polygon.margin(p) for p in inside) > 0.0
    centre = corners[:, :2].mean(axis=0)
    for vertex in polygon.vertices:
        assert abs(polygon.margin(vertex)) < 1e-12
        assert polygon.margin(centre + 1.01 * (vertex - centre)) < 0.0


@pytest.mark.parametrize(
    "points", [[[0, 0], [0.2, 0]], [[0, 0], [0.1, 0], [0.2, 0]], [[0, 0], [1, 0], [np.nan, 1]]]
)
def test_points_that_support_nothing_are_refused(points):
    with pytest.raises(InputError, match="around an area"):
        SupportPolygon.of_points(np.array(points))
